// freeplay plot: plots any columns of result folders together.
#include <fmt/format.h>

#include <filesystem>
#include <string>
#include <vector>

#include "cli/verb.hpp"
#include "io/files/folder_lock.hpp"
#include "io/files/output_file.hpp"
#include "io/files/result_set.hpp"
#include "io/files/run_set.hpp"
#include "mechanism/error.hpp"
#include "plots/drawing/column_plot.hpp"
#include "plots/drawing/figure.hpp"

namespace freeplay::cli {
namespace {

struct PlotRequest : Request {
  std::vector<std::string> folders, y;
  std::vector<std::string> units;
  std::string x = "t", section, name, format, style;
  bool fold = false;
  std::optional<double> from, to;
};

int plot(const PlotRequest& request) {
  plots::ColumnPlot what;
  for (const auto& folder : request.folders) {
    what.folders.push_back(real_folder(folder));
    if (!std::filesystem::is_directory(what.folders.back())) throw SceneError(folder + ": is not a folder");
  }
  what.x = request.x;
  for (const auto& list : request.y) what.panels.push_back(plots::columns_named(list));
  what.units = request.units;
  what.fold = request.fold;
  what.from = request.from;
  what.to = request.to;
  if (!request.section.empty()) what.section = plots::crossing_of(request.section);
  if (!request.name.empty() && request.name != plots::safe_name(request.name))
    throw SceneError(fmt::format("-o {}: must be a file name of letters, digits, _ - and .", request.name));
  what.name = request.name;
  what.formats = plots::formats_named(plots::columns_named(request.format));
  if (!request.style.empty()) plots::choose_style(request.style);
  const FolderLock lock(what.folders.front(), "plot");
  settle_result_sets(what.folders.front());
  settle_run(what.folders.front());
  fmt::print("{}\n", plots::draw_columns(what).string());
  return 0;
}

}  // namespace

void plot_verb(Program& program) {
  auto [options, request] = program.verb("plot", "plot columns of one or more result folders", plot);
  options.add("folder", request.folders, "folders made by run or compare, plotted together").required();
  options.add("--x,--over", request.x, "abscissa: a column, or an expression of columns")
      .takes("COLUMN")
      .shows_default();
  options
      .add("--y", request.y,
           "columns or expressions of one panel; each --y adds a panel; a wrong name lists all")
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
  options
      .add("--format", request.format,
           "pdf, png, svg, eps, cairolatex, separated by commas; default from style.toml")
      .takes("FORMAT");
  options.style(request.style);
}

}  // namespace freeplay::cli
