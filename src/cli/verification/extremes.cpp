// freeplay extremes: tests both formulations at extreme parameters and writes a map of the results.
// Each cell runs in a process of its own.

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <string>

#include "cli/command_line.hpp"
#include "cli/ending.hpp"
#include "cli/folders.hpp"
#include "cli/terminal.hpp"
#include "facade/run_folder.hpp"
#include "facade/simulation.hpp"
#include "io/files/folder_lock.hpp"
#include "io/files/output_file.hpp"
#include "io/files/result_set.hpp"
#include "io/files/run_json.hpp"
#include "plots/drawing/figure.hpp"
#include "verification/random_scenes/extremes/extremes.hpp"
#include "verification/random_scenes/runner.hpp"
#include "verification/support/support.hpp"

namespace freeplay::cli {
namespace {

using namespace verification::random_scenes;

/// Options of the random-scene tests.
struct RandomScenesRequest {
  int count = 0, seed = 1;
  int only = -1;              ///< test this scene only and write it to a file; −1: all
  std::string document = {};  ///< folder for random-scenes.md
  /// Of scenes with a reference for each row; empty: the others, all ways.
  std::string kinds = {}, way = {};
  int first = 0;  ///< number of the first scene with a reference for each row
};

/// Tests one scene: writes its files, and prints a line for each way.
std::vector<Row> judge_only(const RandomScene& scene, const std::string& way,
                            const std::filesystem::path& folder) {
  const bool known = scene.suite == Suite::rows;
  const auto rows = judge_apart(scene, way);
  if (!known) write_file(folder / "scene.toml", scene.text);
  for (const auto& by : ways(scene.suite))
    if (known && (way.empty() || way == by.name) && has_model(scene, by))
      write_file(folder / fmt::format("{}.toml", by.name), text_for(scene, by));
  for (const auto& r : rows)
    fmt::print("{:<24}{:<16}{:>8.2g} s  {} {}\n", r.way, name_of(r.verdict.outcome, scene.suite),
               r.verdict.cpu, r.verdict.check, r.verdict.detail);
  fmt::print("kind {}, in {}\n", scene.kind, folder.string());
  return rows;
}

/// Tests random scenes instead of the map; with `kinds`, scenes with a reference for each row. Exit status 1
/// if there is a defect. `output`: result folder; empty: the default.
int random_scenes(const RandomScenesRequest& request, const std::string& output) {
  const verification::random_scenes::Request requested{
      static_cast<std::uint64_t>(request.seed), request.first, request.count, request.kinds, request.way};
  const bool known = !requested.kinds.empty();
  const auto folder = result_folder(output, known ? "out/random-scenes" : "out/strangers");
  make_folder(folder);
  const FolderLock lock(folder, "extremes");
  const auto began = std::chrono::steady_clock::now();
  const bool all = request.only < 0;
  std::vector<Row> rows;
  if (all) {
    Progress progress;
    rows = judge_all(requested, folder, [&](double done) { progress.show("random scenes", done); });
    progress.clear();
  } else {
    rows = judge_only(draw(requested.seed, request.only, requested.kinds), requested.way, folder);
  }
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
  const auto suite = known ? Suite::rows : Suite::agreement;
  const auto defect = [&](const Row& r) { return is_defect(r.verdict.outcome, suite); };
  const auto defects = std::ranges::count_if(rows, defect);
  if (!known) write_file(folder / "strangers.csv", table_of(rows, requested.seed).csv());
  if (all) {
    const auto text = summary_of(rows, suite);
    if (known) write_file(folder / "random_scenes.md", text);
    fmt::print("{}\n", text);
    for (const auto& r : rows)
      if (!known && defect(r))
        fmt::print("{} {} ({}, {}): {}: {}\n    freeplay extremes --random-scenes {} --seed {} --only {}\n",
                   name_of(r.verdict.outcome, suite), r.index, r.kind, r.way, r.verdict.check,
                   r.verdict.detail, requested.count, requested.seed, r.index);
    fmt::print("{} random scenes of seed {}, {} runs tested in {:.0f} s: {} defects\nresults in {}\n",
               requested.count, requested.seed, rows.size(), seconds, defects, folder.string());
    if (!known && !request.document.empty())
      write_page(request.document, folder, "extremes", "random-scenes.md",
                 page_of(rows, requested.seed, requested.count, seconds));
  }
  return defects == 0 ? 0 : 1;
}

struct ExtremesRequest : Request {
  std::string output;    ///< result folder
  std::string document;  ///< folder for extremes.md and its figure
  RandomScenesRequest scenes;
};

int extremes(const ExtremesRequest& request) {
  if (request.scenes.count > 0) {
    auto requested = request.scenes;
    requested.document = request.document;
    return random_scenes(requested, request.output);
  }
  test::source_folder();  // throws before any test or output
  auto cells = rig_cells();
  for (auto more : {baumgarte_cells(), special_cells()})
    for (auto& c : more) cells.push_back(std::move(c));
  const auto folder = result_folder(request.output, "out/extremes");
  ResultSet set(folder, "extremes");
  Progress progress;
  std::string axis;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    auto& c = cells[i];
    if (request.stop()) return interrupted(Kept::nothing);
    progress.show(c.axis, static_cast<double>(i) / static_cast<double>(cells.size()));
    // s; the longest cell takes 30 s, with sanitizers ten times that.
    c.verdict = judge_apart(c, 1200);
    progress.clear();
    if (c.axis != axis) fmt::print("\n{}\n", axis = c.axis);
    fmt::print("  {:<32}{:<14}{}\n", c.label, c.formulation, name_of(c.verdict.outcome, Suite::map));
    if (c.verdict.outcome != Outcome::right) fmt::print("      {}\n", c.verdict.detail);
    std::fflush(stdout);
  }
  auto origin = provenance();
  origin["scene_file"] = "extremes";
  write_json(set.place() / "extremes.json", to_json(cells), origin);
  write_file(set.place() / "extremes.csv", table_of(cells).csv());
  write_file(set.place() / "limits.csv", limits_table().csv());
  set.commit();
  fmt::print("\n{}; {} defects\nresults in {}\n", totals(cells), defects(cells), folder.string());
  const auto figures = plots::all(folder);
  for (const auto& path : figures) fmt::print("  {}\n", path.string());
  write_page(request.document, folder, "extremes", "extremes.md", page_of(cells), figures);
  return defects(cells) == 0 ? 0 : 1;
}

}  // namespace

void extremes_verb(Program& program) {
  auto [options, request] = program.verb("extremes", extremes_what, extremes);
  options.output(request.output, "result folder");
  options
      .add("--document", request.document,
           "write extremes.md and its figure, or the page of random scenes, into this folder")
      .takes("FOLDER");
  const auto count =
      options.add("--random-scenes,--strangers", request.scenes.count, "test this many random scenes instead")
          .between(1, 1000000);
  options.add("--seed", request.scenes.seed, "seed of the random scenes").needs(count).between(0, 1000000000);
  const auto names = fmt::format(
      "check all rows of scenes of these kinds, with commas: the sets new, elements and surfaces, or {}; or the sets "
      "flexible and beams, or {}",
      fmt::join(verification::random_scenes::kinds(Suite::rows), ", "),
      fmt::join(verification::random_scenes::kinds(Suite::flexible), ", "));
  const auto kinds = options.add("--kinds", request.scenes.kinds, names.c_str()).takes("NAMES").needs(count);
  options.add("--first", request.scenes.first, "with --kinds: number of the first scene")
      .needs(kinds)
      .between(0, 1000000000);
  options.add("--way", request.scenes.way, "with --kinds: use only this scheme or integrator")
      .takes("NAME")
      .needs(kinds);
  options.add("--only", request.scenes.only, "test only the scene of this number and write its scene.toml")
      .needs(count)
      .between(0, 1000000);
}

}  // namespace freeplay::cli
