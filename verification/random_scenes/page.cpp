#include "verification/random_scenes/runner.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <map>
#include <regex>

#include "verification/random_scenes/checks/checks.hpp"

namespace freeplay::verification::random_scenes {
namespace {

/// Reviewed kinds of refusal, by a part of their reason, each with the justification.
struct Refusal {
  const char* part;
  const char* why;
};
constexpr Refusal looked_at[] = {
    {"faster than event-driven integration can resolve",
     "impacts in a pile accumulate without an end in time; the reason names the automatic scheme, which "
     "uses time stepping there"},
    {"too many for event-driven", "as above, at a rate at which no run ends"},
    {"contact mode changes", "as above, of changes between stick and slip"},
    {"no order in which they slip", "as above"},
    {"admits several motions", "Painlevé's paradox: friction admits several motions, which the reason names"},
    {"admits no acceleration",
     "Painlevé's paradox: no finite force is admissible at a sliding contact; time stepping stops it by an "
     "impulse"},
    {"solved the",
     "no solver finds impulses of several contacts (or friction above 1 in a corner); whether they exist "
     "is unknown"},
    {"penalty.tolerance is below rounding",
     "penalty's default integrator finds no step into a hard contact with much damping: an open defect, "
     "other integrators succeed"},
    {"the motion is singular there",
     "the event-driven integrator finds no step: an open defect, time stepping succeeds"},
    {"too stiff for this integrator",
     "a sustained contact is too stiff for an explicit method; the reason names a suitable one"},
    {", and going on",
     "a run that exceeds its CPU time: stiff sustained contacts or very many bounces at high speed; it was "
     "still running"},
    {"the forces of dampers does not converge",
     "a damper that stops its mass within a step; the reason names a sufficient step"},
};

}  // namespace

std::string kind_of_refusal(const std::string& reason) {
  static const std::regex name("\"[^\"]*\"|\\b[bcjld][0-9]+(\\.(rear|front)_(lower|upper))?\\b"),
      number("[-+]?[0-9]+(\\.[0-9]+)?(e[-+]?[0-9]+)?");
  return std::regex_replace(std::regex_replace(reason, name, "*"), number, "#");
}

std::string justification(const std::string& kind) {
  for (const auto& r : looked_at)
    if (kind.find(r.part) != kind.npos) return r.why;
  return {};
}

namespace {

std::string outcomes_of(const std::vector<Row>& rows, Suite suite) {
  std::string text = "| way | runs |", line = "| --- | --- |";
  const auto column = [&](std::string name) {
    for (auto& c : name) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    text += " " + name + " |", line += " --- |";
  };
  std::vector<Outcome> shown;
  for (int o = 0; o < outcomes; ++o)
    if (const std::string name = name_of(static_cast<Outcome>(o), suite); !name.empty())
      shown.push_back(static_cast<Outcome>(o)), column(name);
  text += suite == Suite::rows ? " all rows known |" : " held to 0, 1, 2, 3 touches |";
  text += " CPU s, mean | CPU s, greatest |\n" + line + " --- | --- | --- |\n";
  for (const auto& way : ways(suite)) {
    std::map<Outcome, int> counts;
    int held[4] = {}, all = 0, known = 0;
    double sum = 0, most = 0;
    for (const auto& r : rows) {
      if (r.way != way.name) continue;
      ++counts[r.verdict.outcome], ++all;
      known += r.verdict.known > 0.999;
      ++held[std::clamp(static_cast<int>(r.verdict.known), 0, 3)];
      sum += r.verdict.cpu;
      most = std::max(most, r.verdict.cpu);
    }
    text += fmt::format("| {} | {} |", way.name, all);
    for (const auto o : shown) text += fmt::format(" {} |", counts[o]);
    text += suite == Suite::rows ? fmt::format(" {} |", known) : fmt::format(" {} |", fmt::join(held, " / "));
    text += fmt::format(" {:.2g} | {:.2g} |\n", all ? sum / all : 0, most);
  }
  return text;
}

std::string defects_by_kind(const std::vector<Row>& rows) {
  std::map<std::string, std::map<std::string, std::map<Outcome, long>>> by_kind;
  for (const auto& r : rows) ++by_kind[r.kind][r.way][r.verdict.outcome];
  std::string text =
      "Silent / falsely doubted / refused / slow / crashed of all runs, by kind and way:\n\n| kind |";
  std::string line = "| --- |";
  for (const auto& way : ways(Suite::rows)) text += fmt::format(" {} |", way.name), line += " --- |";
  text += "\n" + line + "\n";
  for (auto& [kind, by_way] : by_kind) {
    text += fmt::format("| {} |", kind);
    for (const auto& way : ways(Suite::rows)) {
      auto& n = by_way[way.name];
      long all = 0;
      for (const auto& [outcome, count] : n) all += count;
      if (all == 0)
        text += " |";
      else
        text += fmt::format(" {}/{}/{}/{}/{} of {} |", n[Outcome::silent], n[Outcome::falsely_doubted],
                            n[Outcome::refused], n[Outcome::hung], n[Outcome::crashed], all);
    }
    text += "\n";
  }
  return text;
}

std::string refusals_of(const std::vector<Row>& rows) {
  std::map<std::pair<std::string, std::string>, std::vector<int>> kinds;
  for (const auto& r : rows)
    if (r.verdict.outcome == Outcome::refused)
      kinds[{r.way, kind_of_refusal(r.verdict.detail)}].push_back(r.index);
  if (kinds.empty()) return "None was refused.\n";
  std::string text =
      "| way | refused, by reason | count | first | why it may be |\n| --- | --- | --- | --- | --- |\n";
  for (const auto& [kind, list] : kinds)
    text += fmt::format("| {} | {} | {} | {} | {} |\n", kind.first, kind.second, list.size(), list[0],
                        justification(kind.second));
  return text;
}

std::string noted_of(const std::vector<Row>& rows) {
  std::map<std::pair<std::string, std::string>, int> kinds;
  for (const auto& r : rows)
    if (r.verdict.outcome == Outcome::doubted) {
      const auto at = r.verdict.detail.find("run says: ");
      auto note =
          kind_of_refusal(at == std::string::npos ? r.verdict.detail : r.verdict.detail.substr(at + 10));
      if (const auto end = note.find_first_of(";("); end != note.npos) note.resize(end);
      ++kinds[{r.way, r.verdict.check + ": " + note}];
    }
  if (kinds.empty()) return "None had a warning.\n";
  std::string text = "| way | outside the bound of, and message | count |\n| --- | --- | --- |\n";
  for (const auto& [kind, count] : kinds)
    text += fmt::format("| {} | {} | {} |\n", kind.first, kind.second, count);
  return text;
}

}  // namespace

std::string summary_of(const std::vector<Row>& rows, Suite suite) {
  return outcomes_of(rows, suite) + "\n" +
         (suite == Suite::rows ? defects_by_kind(rows) : refusals_of(rows) + "\n" + noted_of(rows));
}

Table table_of(const std::vector<Row>& rows, std::uint64_t seed) {
  Table table("seed,index,kind,way,outcome,check,detail");
  for (const auto& r : rows)
    table.row(seed, r.index, r.kind, r.way, name_of(r.verdict.outcome, Suite::agreement),
              r.verdict.check.empty() ? "-" : r.verdict.check, field(r.verdict.detail));
  return table;
}

std::string page_of(const std::vector<Row>& rows, std::uint64_t seed, int count, double seconds) {
  std::string text = fmt::format(
      "# Random-scene tests without a reference\n\nWritten by `freeplay extremes --random-scenes {0} --seed "
      "{1} --document docs/verification`. {0} scenes, drawn by a seed\n"
      "(verification/random_scenes/): {2}.\nLengths "
      "from a millimetre to ten metres, speeds over five decades, mass ratios to 1e6, friction to 1.5, "
      "restitution 0 to 1, starts in contact or grazing.\nEach is run by all applicable schemes and "
      "integrators (no restitution of 0 with penalty), in a separate process and without an\nindependent "
      "reference. *Right*: within every bound below. *Warned*: outside one, with a warning or a note of "
      "the run. *Refused*: stopped with a\nreason, and right until then. *Silent* (wrong without a "
      "warning), *hung* (over {3:.0f} s of CPU) and *crashed* are defects. Wall time {4:.0f} s.\n\n",
      count, seed, fmt::format("{}", fmt::join(kinds(Suite::agreement), ", ")), run_limit(Suite::agreement),
      seconds);
  text += outcomes_of(rows, Suite::agreement) +
          "\n## Checks\n\n| check | what is compared | bound | why |\n| --- | --- | --- | --- |\n";
  for (const auto& c : checks())
    text += fmt::format("| {} | {} | {} | {} |\n", c.name, c.asks, c.bound, c.why);
  text += "\n## Refused\n\n" + refusals_of(rows) + "\n## Warned\n\n" + noted_of(rows) + "\n## Defects\n\n";
  bool any = false;
  for (const auto& r : rows)
    if (is_defect(r.verdict.outcome, Suite::agreement)) {
      any = true;
      text += fmt::format("- {} ({}, {}): {} {}: {}\n", r.index, r.kind, r.way,
                          name_of(r.verdict.outcome, Suite::agreement), r.verdict.check, r.verdict.detail);
    }
  if (!any) text += "None.\n";
  return text +
         fmt::format(
             "\n`freeplay extremes --random-scenes {} --seed {} --only I` writes scene I and tests only "
             "it.\n",
             count, seed);
}

}  // namespace freeplay::verification::random_scenes
