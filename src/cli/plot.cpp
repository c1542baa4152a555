// freeplay plot: plots any columns of result folders together, or measures of a study.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <filesystem>
#include <string>
#include <vector>

#include "cli/command_line.hpp"
#include "cli/folders.hpp"
#include "io/files/escaping.hpp"
#include "io/files/output_file.hpp"
#include "mechanism/error.hpp"
#include "plots/drawing/column_plot.hpp"
#include "plots/drawing/figure.hpp"
#include "plots/studies/study_plot.hpp"

namespace freeplay::cli {
namespace {

struct PlotRequest : Request {
  std::vector<std::string> folders, y;
  std::vector<std::string> units;
  std::string x, section, name, title, format, style;
  bool fold = false;
  std::optional<double> from, to;
};

/// Default folders of the results of a study file: of sweep, bifurcation and basin, and of ensemble.
std::vector<std::filesystem::path> default_folders(const std::filesystem::path& file) {
  std::vector<std::filesystem::path> list;
  for (const char* suffix : {"", "-bifurcation", "-basin", "-ensemble"})
    list.push_back(default_folder(file, suffix));
  return list;
}

/// The folder of a study's results: the folder itself, that of its database, or a default folder of
/// a study file. Empty if the word names none of these. Throws SceneError for a file without
/// results, and for one with results in several folders.
std::filesystem::path folder_of_study(const std::string& word) {
  std::filesystem::path named(word);
  if (std::filesystem::is_regular_file(named)) {
    if (named.extension() == ".db") named = named.has_parent_path() ? named.parent_path() : ".";
    if (named.extension() == ".toml") {
      std::vector<std::string> found, tried;
      for (const auto& folder : default_folders(named)) {
        tried.push_back(folder.string());
        if (plots::holds_study_results(real_folder(folder))) found.push_back(folder.string());
      }
      if (found.empty())
        throw SceneError(fmt::format("{}: has no results of a study in {}; give the folder of the results",
                                     visible_brief(word, 60), fmt::join(tried, ", ")));
      if (found.size() > 1)
        throw SceneError(fmt::format("{}: has results in {}; give one of these folders",
                                     visible_brief(word, 60), fmt::join(found, " and ")));
      named = found.front();
    }
  }
  const auto folder = real_folder(named);
  // A run in the same folder is plotted by its columns.
  const bool run =
      std::filesystem::exists(folder / "run.json") || std::filesystem::exists(folder / "comparison.json");
  return !run && plots::holds_study_results(folder) ? folder : std::filesystem::path();
}

int plot_study(const PlotRequest& request, const std::filesystem::path& folder) {
  if (request.folders.size() > 1)
    throw SceneError(fmt::format("{}: is a study, which is plotted alone; give one folder",
                                 visible_brief(request.folders.front(), 60)));
  if (!request.units.empty())
    throw SceneError(
        "plot: --unit is for runs; a study states units in its file, for example\n  [derived] speed_mm = "
        "\"1000*speed\" with [units] speed_mm = \"mm/s\". Then repeat `freeplay sweep`.");
  if (!request.section.empty() || request.from || request.to || request.fold)
    throw SceneError("plot: --from, --to, --section and --fold are for runs, not for the results of a study");
  plots::StudyPlot what{.folder = folder,
                        .y = {},
                        .x = plots::columns_named(request.x),
                        .name = request.name,
                        .title = request.title};
  for (const auto& list : request.y)
    for (const auto& name : plots::columns_named(list)) what.y.push_back(name);
  if (what.y.empty()) throw SceneError("--y: names nothing");
  if (!request.style.empty()) plots::choose_style(request.style);
  what.formats = plots::formats_named(plots::columns_named(request.format));
  const FolderLock lock(folder, "plot");
  settle_result_sets(folder);
  fmt::print("{}\n", plots::draw_study(what).string());
  return 0;
}

int plot(const PlotRequest& request) {
  if (!request.name.empty() && request.name != safe_name(request.name))
    throw SceneError(fmt::format("-o {}: must be a file name of letters, digits, _ - and .", request.name));
  if (const auto folder = folder_of_study(request.folders.front()); !folder.empty())
    return plot_study(request, folder);
  plots::ColumnPlot what;
  for (const auto& folder : request.folders) what.folders.push_back(named_results(folder));
  if (!request.x.empty()) what.x = request.x;
  for (const auto& list : request.y) what.panels.push_back(plots::columns_named(list));
  what.units = request.units;
  what.fold = request.fold;
  what.from = request.from;
  what.to = request.to;
  if (!request.section.empty()) what.section = plots::crossing_of(request.section);
  what.name = request.name;
  what.title = request.title;
  what.formats = plots::formats_named(plots::columns_named(request.format));
  if (!request.style.empty()) plots::choose_style(request.style);
  const auto lock = lock_results(what.folders.front(), "plot");
  fmt::print("{}\n", plots::draw_columns(what).string());
  return 0;
}

}  // namespace

void plot_verb(Program& program) {
  auto [options, request] =
      program.verb("plot", "plot columns of result folders, or measures of a study", plot);
  options
      .add("folder", request.folders,
           "folders made by run, compare or orbit, plotted together; or one of sweep, ensemble, "
           "bifurcation or basin")
      .required();
  options
      .add("--x,--over", request.x,
           "abscissa: a column or an expression of columns; default t. Of a sweep: one axis for curves, "
           "two for "
           "a map, AXIS,AXIS")
      .takes("COLUMN");
  options
      .add("--y", request.y,
           "columns or expressions of one panel; each --y adds a panel; of a study measures; a wrong name "
           "lists "
           "all")
      .takes("COLUMN[,COLUMN...]")
      .required()
      .one_each();
  options
      .add("--unit", request.units,
           "unit of the axes of this dimension, such as deg, mm, rpm; or of one AXIS: x, y, y1 to y6; may be "
           "repeated")
      .takes("[AXIS=]UNIT")
      .one_each();
  options.flag("--fold", request.fold, "show the abscissa, an angle, within one turn of 360 degrees");
  options.add("--from", request.from, "start time, s").takes("SECONDS");
  options.add("--to", request.to, "end time, s").takes("SECONDS");
  options
      .add("--section", request.section,
           "COLUMN=VALUE[:up|:down] or crank=DEGREES: plot only points at these instants")
      .takes("WHERE");
  options
      .add("-o,--output", request.name,
           "name of the figure in figures/ of the first folder; default from its columns")
      .takes("NAME");
  options.add("--title", request.title, "title above the panels; without it, or empty, the figure has none")
      .takes("TEXT");
  options
      .add("--format", request.format,
           "pdf, png, svg, eps, cairolatex, separated by commas; default from style.toml")
      .takes("FORMAT");
  options.style(request.style);
}

}  // namespace freeplay::cli
