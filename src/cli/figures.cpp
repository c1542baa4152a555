// freeplay figures: draws the figures of a result folder again, or those of a published paper.

#include "cli/figures.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>

#include "cli/command_line.hpp"
#include "cli/ending.hpp"
#include "cli/folders.hpp"
#include "cli/terminal.hpp"
#include "facade/simulation.hpp"
#include "io/files/folder_lock.hpp"
#include "io/files/output_file.hpp"
#include "io/files/result_set.hpp"
#include "io/files/run_json.hpp"
#include "mechanism/error.hpp"
#include "mechanism/scene.hpp"
#include "plots/drawing/column_plot.hpp"
#include "plots/drawing/figure.hpp"
#include "plots/drawing/style.hpp"
#include "plots/figures/experiment.hpp"
#include "simulation/table_rows.hpp"
#include "study/settings/study.hpp"
#include "study/sweep/sweep.hpp"
#include "study/sweep/sweep_table.hpp"

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
  plots::add_state_functions(scene, list);
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

void draw_results(const std::filesystem::path& folder, Undrawn undrawn, const StopToken& stop) try {
  fmt::print("results in {}\n", folder.string());
  for (const auto& path : plots::all(folder, stop)) fmt::print("figure: {}\n", path.string());
} catch (const OutputError& e) {
  if (undrawn == Undrawn::is_error) throw;
  fmt::print(stderr, "figures: {}\n", e.what());
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

namespace {

/// A file of a paper's study, copied into the program.
struct PaperFile {
  const char *paper, *file, *text;
};
constexpr PaperFile paper_files[] = {
#include "papers.inc"
};
constexpr const char* study_of_paper = "figures.toml";

void print(const std::vector<std::filesystem::path>& figures) {
  for (const auto& path : figures) fmt::print("{}\n", path.string());
}

/// Papers whose figures can be drawn.
std::vector<std::string> papers() {
  std::vector<std::string> names;
  for (const auto& one : paper_files)
    if (std::ranges::find(names, one.paper) == names.end()) names.emplace_back(one.paper);
  return names;
}

struct PaperRequest {
  std::string paper;   ///< one of papers()
  std::string output;  ///< result folder; empty: out/paper-NAME
  int threads = 0;     ///< 0: all cores
};

/// Makes the missing runs of the paper's study in the result folder and draws the figures by their
/// numbers in the paper. A folder with the results of `validate` is drawn as it is, without runs.
/// Returns the exit status.
int paper_figures(const PaperRequest& request, const Conduct& conduct) {
  const auto folder =
      result_folder(request.output, std::filesystem::path("out") / ("paper-" + request.paper));
  if (std::filesystem::exists(folder / "experiment.json")) {
    const FolderLock lock(folder, "figures");
    settle_result_sets(folder);
    print(plots::draw_flores2011(folder, "experiment.json"));
    return 0;
  }
  ResultSet set(folder, "paper");
  for (const auto& one : paper_files)
    if (one.paper == request.paper) write_file(folder / one.file, one.text);
  const auto study = read_study(folder / study_of_paper, Reach::beside);
  const auto planned = plan(study, conduct);
  if (conduct.stop()) return interrupted(Kept::nothing);
  Results results(folder / "sweep.db", study, conduct.stop);
  fmt::print(stderr,
             "figures of {}: {} runs of {} variants, without those already stored in {}; takes minutes\n",
             request.paper, planned.size(), study.variants.size(), folder.string());
  Progress progress;
  const auto summary =
      sweep(study, planned, conduct, results, set.lock(), request.threads, progress.of_runs());
  progress.clear();
  if (summary.interrupted) return interrupted(Kept::runs);
  write_sweep_document(study, results, folder);
  write_json(set.place() / "paper.json",
             {{"paper", {{"name", request.paper}, {"runs", summary.total}, {"failed", summary.failed}}}},
             provenance(study));
  write_tables(study, results, conduct, set.place());
  set.commit();
  fmt::print("{} runs, {} of them new, in {:.0f} s; results in {}\n", summary.total, summary.ran,
             summary.wall_seconds, folder.string());
  print(plots::draw_flores2011(folder, "paper.json"));
  for (const auto& [variant, formulation, reason] : results.failures())
    fmt::print(stderr, "{}, {}: {}\n", variant, formulation, reason);
  return results.failures().empty() ? 0 : 1;
}

struct FiguresRequest : Request {
  std::string folder;
  PaperRequest paper;
  std::string style;  ///< preset or file
};

int figures(const FiguresRequest& request) {
  if (!request.style.empty()) plots::choose_style(request.style);
  if (!request.paper.paper.empty()) return paper_figures(request.paper, request.conduct());
  if (request.folder.empty())
    throw SceneError(
        fmt::format("figures: needs a result folder to draw, or --paper {} for the figures of a paper",
                    papers().front()));
  const auto folder = named_results(request.folder);
  const auto lock = lock_results(folder, "figures");
  const auto made = plots::all(folder);
  if (made.empty())
    throw SceneError(request.folder +
                     ": contains no result files to draw; give a folder made by freeplay run, compare, "
                     "orbit, continue, lyapunov, laws, drift or validate");
  for (const auto& path : made) fmt::print("{}\n", path.string());
  return 0;
}

}  // namespace

void figures_verb(Program& program) {
  auto [options, request] =
      program.verb("figures", "redraw the figures of a result folder, or draw those of a paper", figures);
  auto folder =
      options.add("folder", request.folder,
                  "folder made by run, compare, orbit, continue, lyapunov, laws, drift or validate");
  auto paper = options
                   .add("--paper", request.paper.paper,
                        "draw the figures of this paper by their numbers; makes the runs that are missing")
                   .one_of(papers())
                   .excludes(folder);
  options.output(request.paper.output, "result folder of --paper; default out/paper-PAPER").needs(paper);
  options.threads(request.paper.threads).needs(paper);
  options.style(request.style);
}

}  // namespace freeplay::cli
