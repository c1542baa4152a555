// Lubricant films in the nonsmooth schemes: extreme parameters, hand-overs to dry contact, several
// joints. Closed forms are in verification/claims/films.cpp.
#include "verification/support/rig.hpp"

using namespace freeplay;

namespace {

using test::Way;
const std::vector<Way> ways{test::fixed_steps(1e-5),
                            test::chosen_steps,
                            test::event_driven,
                            test::automatic,
                            {"penalty", Family::penalty, {}, 0, {"penalty.contact=\"exact\""}}};

Scene pin(std::vector<std::string> keys, const Way& way) {
  keys.insert(keys.end(), way.options.begin(), way.options.end());
  keys.push_back("run.discard=0");
  auto scene = read_scene(test::source_folder() / "cases/lubricated-pin/scene.toml", keys);
  way.choose(scene);
  return scene;
}

Result finished(const Scene& scene, const Way& way) {
  auto run = test::finished(scene, way.family);
  CHECK(std::abs(run.ledger.closure()) < 1e-6 * run.ledger.scale());
  return run;
}

}  // namespace

TEST_CASE("films of any thickness and kind: every scheme finishes with the same result", "[films]") {
  // thin oil, grease, a tiny clearance, kinds of films, and a wide hand-over
  auto keys = GENERATE(values<std::vector<std::string>>(
      {{"lubricants.oil.viscosity=0.01"},
       {"lubricants.oil.viscosity=100.0"},
       {"joints.gudgeon.clearance=5e-6"},
       {"lubricants.oil.film=\"long\"", "lubricants.oil.cavitation=\"none\""},
       {"lubricants.oil.film=\"long\""},
       {"lubricants.oil.film=\"finite\""},
       {"lubricants.oil.cavitation=\"none\""},
       {"lubricants.oil.hand_over=1e-4"}}));
  const double c = keys[0].starts_with("joints") ? 5e-6 : 0.25e-3;
  keys.push_back("run.revolutions=0.25");
  const auto exact = finished(pin(keys, ways.back()), ways.back());
  for (const auto& way : ways) {
    const auto run = finished(pin(keys, way), way);
    CAPTURE(keys, way.name);
    // h² of the film's rates for fixed steps of 1e-5 s, 1e-6 a step for adaptive ones.
    CHECK(std::abs(run.final_state.q[6] - exact.final_state.q[6]) < 1e-3 * c);
    CHECK(std::abs(run.final_state.q[4] - exact.final_state.q[4]) < 1e-3 * c);
    CHECK(run.ledger.film == Approx(exact.ledger.film).epsilon(5e-3));
    CHECK(run.ledger.film > 0);
    CHECK(run.ledger.contact == 0);
  }
}

TEST_CASE("where the film is too thin to carry the load, dry contact takes over at zero gap", "[films]") {
  for (const auto& way : ways) {
    auto scene = pin({"lubricants.oil.viscosity=1e-4", "run.revolutions=0.25"}, way);
    const auto run = finished(scene, way);
    CAPTURE(way.name);
    // With the impact law a contact bounces that stays closed in penalty under the depth of the
    // load.
    CHECK((run.contacts[0].impacts > 0 || way.family == Family::penalty));
    CHECK(run.contacts[0].lasting_fraction > 0);
    CHECK(run.ledger.film > 0);
    CHECK(run.ledger.contact > 0);
    if (way.family == Family::nonsmooth) CHECK(run.contacts[0].penetration_ratio < 1e-3);
  }
}

TEST_CASE("a fixed step longer than the passage of a film's thickness is reported", "[films]") {
  const auto coarse = test::fixed_steps(2e-3);
  const auto run = finished(pin({"lubricants.oil.viscosity=0.002", "run.revolutions=0.3"}, coarse), coarse);
  CHECK_THAT(test::notes_of(run), Catch::Contains("film"));
  const auto fine = finished(pin({"run.revolutions=0.1"}, ways[0]), ways[0]);
  CHECK_THAT(test::notes_of(fine), !Catch::Contains("film"));
}
