// Results of the map of extreme parameters.
#include <fmt/format.h>
#include <algorithm>
#include <nlohmann/json.hpp>

#include "mechanism/error.hpp"
#include "verification/random_scenes/extremes/extremes.hpp"
#include "verification/support/apart.hpp"
#include "verification/support/support.hpp"

namespace freeplay::verification::random_scenes {

namespace {

std::string without_commas(std::string text) {
  std::erase(text, ',');
  return text;
}

const char* name_of(const Cell& c) { return name_of(c.verdict.outcome, Suite::map); }

}  // namespace

std::string totals(const std::vector<Cell>& cells) {
  const auto count = [&](Outcome o) {
    return std::ranges::count_if(cells, [&](const Cell& c) { return c.verdict.outcome == o; });
  };
  return fmt::format("{} cells: {} right, {} degraded with a warning, {} refused", cells.size(),
                     count(Outcome::right), count(Outcome::doubted), count(Outcome::refused));
}

int defects(const std::vector<Cell>& cells) {
  return static_cast<int>(
      std::ranges::count_if(cells, [](const Cell& c) { return is_defect(c.verdict.outcome, Suite::map); }));
}

nlohmann::json to_json(const std::vector<Cell>& cells) {
  auto list = nlohmann::json::array(), limits = list;
  for (const auto& c : cells)
    list.push_back({{"axis", c.axis},
                    {"label", c.label},
                    {"value", c.value},
                    {"formulation", c.formulation},
                    {"outcome", name_of(c)},
                    {"detail", c.verdict.detail}});
  for (const auto& l : predicted_limits())
    limits.push_back(
        {{"axis", l.axis}, {"formulation", l.formulation}, {"value", l.value}, {"source", l.source}});
  return {{"cells", list}, {"limits", limits}};
}

Table table_of(const std::vector<Cell>& cells) {
  Table table("axis,label,value,formulation,outcome,detail");
  for (const auto& c : cells)
    table.row(without_commas(c.axis), without_commas(c.label), c.value, c.formulation, name_of(c),
              field(c.verdict.detail));
  return table;
}

Table limits_table() {
  Table table("axis,formulation,value");
  for (const auto& l : predicted_limits()) table.row(without_commas(l.axis), l.formulation, l.value);
  return table;
}

std::string page_of(const std::vector<Cell>& cells) {
  std::string text =
      "# Extreme parameters\n\nWritten by `freeplay extremes --document docs/verification`. Each cell is "
      "a scene with "
      "extreme parameters, run in a separate process:\n*right*: within a bound of a reference (the paper's "
      "rig along an axis: its first two contact events against an independent solution),\n*degraded*: "
      "outside the bound, with a warning or a note of Painlevé's paradox; *refused*: stopped with a "
      "reason. A wrong result without a warning, a hang or a crash is a defect and fails the "
      "suite.\n\n![map](figures/extremes.png)\n\nCells that are not right:\n\n| axis | value | formulation "
      "| outcome | message | \n| --- | --- | --- | --- | --- |\n";
  for (const auto& c : cells)
    if (c.verdict.outcome != Outcome::right)
      text += fmt::format("| {} | {} | {} | {} | {} |\n", c.axis, c.label, c.formulation, name_of(c),
                          c.verdict.detail);
  text += fmt::format("\n{}, {} defects.\n\nPredicted limits, drawn in the map:\n\n", totals(cells),
                      defects(cells));
  for (const auto& l : predicted_limits())
    text += fmt::format("- {}, {}: {:.3g} ({}).\n", l.axis, l.formulation, l.value, l.source);
  return text;
}

Verdict judge_apart(const Cell& cell, double seconds) {
  const auto work = [&cell] {
    Verdict v;
    try {
      v = cell.assess();
    } catch (const SceneError& e) {
      v = {Outcome::refused, e.what()};
      const std::string here =
          test::source_folder().string() + "/";  // the page must not depend on the machine
      if (v.detail.starts_with(here)) v.detail.erase(0, here.size());
    } catch (const std::exception& e) {
      v = {Outcome::crashed, e.what()};
    }
    return static_cast<char>('0' + static_cast<int>(v.outcome)) + v.detail;
  };
  const auto apart = run_apart(work, seconds);
  if (apart.late) return {Outcome::hung, "no end within its time"};
  if (apart.signal != 0 || apart.said.empty())
    return {Outcome::crashed, "signal " + std::to_string(apart.signal)};
  return {static_cast<Outcome>(apart.said[0] - '0'), apart.said.substr(1)};
}

}  // namespace freeplay::verification::random_scenes
