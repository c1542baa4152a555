// freeplay extremes: the map of what holds at the edges, each cell in a process of its own.
#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "cli/default_folder.hpp"
#include "cli/document.hpp"
#include "cli/ending.hpp"
#include "cli/progress.hpp"
#include "cli/random_scenes.hpp"
#include "cli/strangers.hpp"
#include "cli/verb.hpp"
#include "facade/run_folder.hpp"
#include "facade/simulation.hpp"
#include "io/files/output_file.hpp"
#include "io/files/result_set.hpp"
#include "io/files/run_json.hpp"
#include "plots/drawing/figure.hpp"
#include "verification/extremes/extremes.hpp"
#include "verification/support/support.hpp"

namespace freeplay::cli {

namespace {

struct ExtremesRequest : Request {
  std::string output;    ///< result folder
  std::string document;  ///< folder for extremes.md and its figure
  StrangersRequest strangers;
};

int extremes(const ExtremesRequest& request) {
  using namespace verification;
  if (request.strangers.count > 0) {
    auto asked = request.strangers;
    if (!asked.kinds.empty()) return random_scenes(asked, result_folder(request.output, "out/random-scenes"));
    asked.document = request.document;
    return strangers(asked, result_folder(request.output, "out/strangers"));
  }
  test::source_folder();  // throws before anything is judged or written
  auto cells = rig_cells();
  for (auto more : {baumgarte_cells(), special_cells()})
    for (auto& c : more) cells.push_back(std::move(c));
  const auto folder = result_folder(request.output, "out/extremes");
  ResultSet set(folder, "extremes");
  Progress progress;
  std::string csv = "axis,label,value,formulation,outcome,detail\n", axis;
  nlohmann::json list = nlohmann::json::array();
  int defects = 0, counts[6] = {};
  std::string text =
      "# The extremes\n\nWritten by `freeplay extremes --document docs`. Each cell is a scene at the edge of "
      "what can be "
      "asked, judged in a process of its own:\n*right* within a bound of a reference (the paper's rig along "
      "an axis: its first "
      "two touches against the hand-derived oracle),\n*degraded* outside it and the program said so "
      "(DOUBTFUL, or Painlevé's), "
      "*refused* with a reason. "
      "Silently wrong, hung or crashed is a defect and fails the "
      "suite.\n\n![map](figures/extremes.png)\n\nCells that are not "
      "right:\n\n| axis | value | formulation | outcome | what the program said |\n| --- | --- | --- | --- | "
      "--- |\n";
  for (std::size_t i = 0; i < cells.size(); ++i) {
    auto& c = cells[i];
    if (request.stop()) return interrupted(Kept::nothing);
    progress.show(c.axis, static_cast<double>(i) / static_cast<double>(cells.size()));
    c.verdict = judge_apart(c, 1200);  // half a minute for the longest; sanitizers take ten times that
    progress.clear();
    if (c.axis != axis) fmt::print("\n{}\n", axis = c.axis);
    fmt::print("  {:<32}{:<14}{}\n", c.label, c.formulation, name_of(c.verdict.outcome));
    if (c.verdict.outcome != Outcome::right) fmt::print("      {}\n", c.verdict.detail);
    std::fflush(stdout);
    if (c.verdict.outcome != Outcome::right)
      text += fmt::format("| {} | {} | {} | {} | {} |\n", c.axis, c.label, c.formulation,
                          name_of(c.verdict.outcome), c.verdict.detail);
    ++counts[static_cast<int>(c.verdict.outcome)];
    defects += is_defect(c.verdict.outcome);
    auto detail = c.verdict.detail, label = c.label, name = c.axis;
    std::ranges::replace(detail, ',', ';');
    if (detail.empty()) detail = "-";
    std::erase(label, ',');
    std::erase(name, ',');
    csv += fmt::format("{},{},{},{},{},{}\n", name, label, c.value, c.formulation, name_of(c.verdict.outcome),
                       detail);
    list.push_back({{"axis", c.axis},
                    {"label", c.label},
                    {"value", c.value},
                    {"formulation", c.formulation},
                    {"outcome", name_of(c.verdict.outcome)},
                    {"detail", c.verdict.detail}});
  }
  nlohmann::json limits = nlohmann::json::array();
  std::string limit_csv = "axis,formulation,value\n";
  for (const auto& l : predicted_limits()) {
    limits.push_back(
        {{"axis", l.axis}, {"formulation", l.formulation}, {"value", l.value}, {"source", l.source}});
    auto name = l.axis;
    std::erase(name, ',');
    limit_csv += fmt::format("{},{},{}\n", name, l.formulation, l.value);
  }
  auto origin = provenance();
  origin["scene_file"] = "extremes";
  write_file(set.place() / "extremes.json",
             nlohmann::json{{"provenance", origin}, {"cells", list}, {"limits", limits}}.dump(
                 1, ' ', false, nlohmann::json::error_handler_t::replace) +
                 "\n");
  write_file(set.place() / "extremes.csv", csv);
  write_file(set.place() / "limits.csv", limit_csv);
  set.commit();
  fmt::print("\n{} cells: {} right, {} degraded and said so, {} refused; {} defects\nresults in {}\n",
             cells.size(), counts[0], counts[1], counts[2], defects, folder.string());
  const auto figures = plots::all(folder);
  for (const auto& path : figures) fmt::print("  {}\n", path.string());
  if (!request.document.empty()) {
    text += fmt::format(
        "\n{} cells: {} right, {} degraded and said so, {} refused, {} defects.\n\nPredicted limits, drawn "
        "over the map:\n\n",
        cells.size(), counts[0], counts[1], counts[2], defects);
    for (const auto& l : predicted_limits())
      text += fmt::format("- {}, {}: {:.3g} ({}).\n", l.axis, l.formulation, l.value, l.source);
    const auto place = real_folder(request.document);
    const auto lock = lock_document(place, folder, "extremes");
    copy_figures(figures, place);
    write_file(place / "extremes.md", text);
  }
  return defects == 0 ? 0 : 1;
}

}  // namespace

void extremes_verb(Program& program) {
  auto [options, request] =
      program.verb("extremes", "the map of what holds at the edges; fails on a silent error", extremes);
  options.output(request.output, "result folder");
  options
      .add("--document", request.document,
           "write extremes.md and its figure, or strangers.md, into this folder")
      .takes("FOLDER");
  const auto count = options
                         .add("--strangers", request.strangers.count,
                              "judge this many scenes that nobody designed, in place of the map")
                         .between(1, 1000000);
  options.add("--seed", request.strangers.seed, "of the strangers").needs(count).between(0, 1000000000);
  const auto kinds =
      options
          .add("--kinds", request.strangers.kinds,
               "judge every row of scenes of these kinds, \"new\" for all: table, stop, barrier, ...")
          .takes("NAMES")
          .needs(count);
  options.add("--first", request.strangers.first, "with --kinds: begin with this one of them")
      .needs(kinds)
      .between(0, 1000000000);
  options.add("--way", request.strangers.way, "with --kinds: run by this scheme or integrator alone")
      .takes("NAME")
      .needs(kinds);
  options.add("--only", request.strangers.only, "judge this one of them alone and write its scene.toml")
      .needs(count)
      .between(0, 1000000);
}

}  // namespace freeplay::cli
