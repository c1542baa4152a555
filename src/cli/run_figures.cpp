#include "cli/run_figures.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "cli/wrapped.hpp"
#include "facade/simulation.hpp"
#include "io/files/folder_lock.hpp"
#include "io/files/output_file.hpp"
#include "mechanism/error.hpp"
#include "mechanism/scene.hpp"
#include "plots/drawing/column_plot.hpp"
#include "plots/drawing/figure.hpp"
#include "simulation/columns.hpp"

namespace freeplay::cli {
namespace {

/// The columns that the run's files will have.
std::vector<plots::Column> columns_to_be(const Scene& scene, const std::string& formulation) {
  const Simulation simulation(scene, formulation, {});
  const auto& layout = simulation.layout();
  std::vector<plots::Column> list;
  const auto add = [&](const std::string& name, const char* file) {
    list.push_back({name, file, "", std::string(plots::unit_of_column(name))});
  };
  for (const auto& c : trajectory_columns(layout))
    if (c.of != Column::Of::time) add(c.name(), "trajectory.csv");
  if (scene.run.forces)
    for (const auto& c : force_columns(layout))
      if (c.of != Column::Of::time) add(c.name(), "forces.csv");
  for (const auto& c : layout.channels) add(c, "signals.csv");
  return list;
}

void require_columns(const RunFigures& figures, const Scene& scene, const std::string& formulation) {
  if (figures.plot.empty()) return;
  const auto all = columns_to_be(scene, formulation);
  for (const auto& list : figures.plot)
    for (const auto& name : plots::columns_named(list)) {
      const bool of_events = name.find('.') == name.npos && !plots::unit_of_column(name).empty();
      if (of_events && name != "t") continue;
      try {
        plots::formula_of(name, all);
      } catch (const SceneError& e) {
        throw SceneError(fmt::format("--plot: {}{}", e.what(),
                                     scene.run.forces ? "" : "\n  and those of forces.csv with --forces"));
      }
    }
}

}  // namespace

void require_figures(const RunFigures& figures, const Scene& scene, const std::string& formulation,
                     const std::filesystem::path& folder) {
  if (figures.none && figures.plot.empty()) return;
  plots::style_of(folder, scene.file);
  require_columns(figures, scene, formulation);
}

void draw_results(const std::filesystem::path& folder) {
  try {
    for (const auto& path : plots::all(folder)) fmt::print("figure: {}\n", path.string());
  } catch (const OutputError& e) {
    fmt::print(stderr, "figures: {}\n", e.what());
  }
}

void draw_run(const RunFigures& figures, const std::filesystem::path& folder, const StopToken& stop) {
  const FolderLock lock(folder, "run");
  plots::remove_of_run(folder);
  std::vector<std::filesystem::path> made;
  try {
    if (!figures.none) made = plots::all(folder, stop);
  } catch (const OutputError& e) {
    fmt::print(stderr, "figures: {}\n", e.what());
  }
  for (const auto& list : figures.plot) {
    plots::ColumnPlot what;
    what.folders = {folder};
    what.panels = {plots::columns_named(list)};
    made.push_back(plots::draw_columns(what));
  }
  if (made.empty()) return;
  std::string names;
  for (const auto& path : made) names += (names.empty() ? "" : ", ") + path.filename().string();
  fmt::print("{}", wrapped(fmt::format("figures in {}: {}\n", (folder / "figures").string(), names)));
}

}  // namespace freeplay::cli
