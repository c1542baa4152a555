// Crash-recovery tests of commands: a kill at any instant loses no finished result.
#include "verification/process/crash_recovery/campaign.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;
using namespace freeplay::killed;

namespace {

void check(const Tally& tally) {
  for (const auto& finding : tally.findings) FAIL_CHECK(finding);
  CHECK(tally.lost + tally.stuck + tally.other + tally.left_over == 0);
}

Verb verb_called(const std::vector<Verb>& list, const std::string& name) {
  for (const auto& verb : list)
    if (verb.name == name) return verb;
  throw std::runtime_error(name);
}

void check_random(const Verb& verb, const Path& place) {
  INFO(verb.name);
  Campaign campaign(verb, place / verb.name);
  campaign.at_random(2, 1);
  CHECK(campaign.tally().kills == 2);
  check(campaign.tally());
}

/// Kills before every n-th change of a name: the last ones replace the older results by the new ones.
void check_replacement(const char* name, int every) {
  test::TemporaryFolder place;
  Campaign campaign(verb_called(verbs(place.path()), name), place.path() / name);
  campaign.at_changes(3, every);
  CHECK(campaign.tally().kills >= 4);
  check(campaign.tally());
}

}  // namespace

TEST_CASE("after a kill at a random instant a run and a sweep resume without loss", "[crash-recovery]") {
  test::TemporaryFolder place;
  for (const char* name : {"run", "sweep"})
    check_random(verb_called(verbs(place.path()), name), place.path());
}

TEST_CASE("after a kill at a random instant every command resumes without loss", "[crash-recovery][slow]") {
  test::TemporaryFolder place;
  for (const auto& verb : verbs(place.path())) check_random(verb, place.path());
}

TEST_CASE("after a kill during replacement, either the old or the new results are complete: laws",
          "[crash-recovery]") {
  check_replacement("laws", 29);
}

TEST_CASE("after a kill during replacement, either the old or the new results are complete: run, compare",
          "[crash-recovery][slow]") {
  check_replacement("run", 2);
  check_replacement("compare", 29);
}

// scripts/kill-test sets the number of kills.
TEST_CASE("crash-recovery campaign", "[.campaign]") {
  const char* requested = std::getenv("FREEPLAY_KILLS");
  if (!requested) return;  // tests excluded by name include hidden ones
  const char* seed = std::getenv("FREEPLAY_SEED");
  const int kills = std::atoi(requested);
  test::TemporaryFolder place;
  auto list = verbs(place.path());
  if (const char* only = std::getenv("FREEPLAY_KILL_VERBS"))  // "poincare basin"
    std::erase_if(list, [&](const Verb& verb) {
      return (" " + std::string(only) + " ").find(" " + verb.name + " ") == std::string::npos;
    });
  REQUIRE_FALSE(list.empty());
  fmt::print(
      "| verb | kills at random | before each change of names | lost | stuck | other results | left over |\n"
      "| --- | --- | --- | --- | --- | --- | --- |\n");
  int done = 0, verbs_left = static_cast<int>(list.size());
  for (const auto& verb : list) {
    Campaign random(verb, place.path() / (verb.name + "-random"));
    random.at_random((kills - done) / verbs_left--, seed ? static_cast<unsigned>(std::atoi(seed)) : 1);
    done += random.tally().kills;
    Tally both = random.tally();
    Campaign each(verb, place.path() / (verb.name + "-each"));
    each.at_changes(1, 1);
    const auto& t = each.tally();
    both.lost += t.lost, both.stuck += t.stuck, both.other += t.other, both.left_over += t.left_over;
    both.findings.insert(both.findings.end(), t.findings.begin(), t.findings.end());
    fmt::print("| {} | {} | {} | {} | {} | {} | {} |\n", verb.name, random.tally().kills, t.kills, both.lost,
               both.stuck, both.other, both.left_over);
    std::fflush(stdout);
    check(both);
  }
}
