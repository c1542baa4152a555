#include "plots/studies/study_plot.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>

#include "io/files/input_file.hpp"
#include "mechanism/error.hpp"
#include "plots/drawing/column_title.hpp"
#include "plots/drawing/figure.hpp"
#include "plots/drawing/heat_map.hpp"
#include "plots/drawing/panels.hpp"
#include "plots/figures/attractors.hpp"
#include "plots/figures/ensemble.hpp"
#include "plots/studies/sweep_runs.hpp"
#include "plots/tables/columns.hpp"
#include "plots/tables/table.hpp"
#include "study/store/results.hpp"

namespace freeplay::plots {
namespace {

struct StudyKind {
  const char* file;  ///< marks the results
  std::filesystem::path (*draw)(const StudyPlot&);
};
constexpr StudyKind study_kinds[] = {{"sweep.db", draw_sweep},
                                     {"ensemble.json", draw_ensemble_of},
                                     {"bifurcation.json", draw_bifurcation_of},
                                     {"basin.json", draw_basin_of}};

const StudyKind* kind_of_study(const std::filesystem::path& folder) {
  const auto* it = std::ranges::find_if(
      study_kinds, [&](const StudyKind& kind) { return std::filesystem::exists(folder / kind.file); });
  return it == std::end(study_kinds) ? nullptr : it;
}

}  // namespace

bool holds_study_results(const std::filesystem::path& folder) { return kind_of_study(folder) != nullptr; }

std::filesystem::path draw_study(const StudyPlot& plot) {
  const auto* kind = kind_of_study(plot.folder);
  if (!kind)
    throw SceneError(plot.folder.string() +
                     ": has no results of freeplay sweep, ensemble, bifurcation or basin");
  return kind->draw(plot);
}

std::string name_of_plot(const StudyPlot& plot, const char* kind, const std::string& more) {
  if (!plot.name.empty()) return plot.name;
  return file_name(kind, fmt::format("{}{}", fmt::join(plot.y, "-"), more));
}

// Chosen columns of an ensemble as bands over time, or chosen statistics as histograms over the
// starts. A histogram of n values has ⌈2 n^⅓⌉ classes of equal width (Rice's rule), at most 40.

namespace {

constexpr std::size_t most_histograms = 4, most_classes = 40;

std::vector<std::string> bands_of_ensemble(const std::filesystem::path& folder) {
  const ReadTable table(folder / "bands.csv", {"column"}, {});
  std::vector<std::string> names;
  for (const auto& name : table.text("column")) place_in(names, name);
  return names;
}

std::vector<std::string> statistics_of_ensemble(const std::filesystem::path& folder) {
  auto names = Rows(folder / "starts.csv").names();
  std::erase_if(names, [](const std::string& name) { return name == "start" || name == "finished"; });
  return names;
}

/// Finite values of one statistic over the starts.
std::vector<double> values_over_starts(const std::filesystem::path& folder, const std::string& statistic) {
  Rows rows(folder / "starts.csv");
  const auto place = rows.place(statistic);
  std::vector<double> values;
  while (rows.next())
    if (const double x = rows.maybe_number(place); std::isfinite(x)) values.push_back(x);
  return values;
}

Panel histogram(Figure& f, const std::filesystem::path& folder, const std::string& statistic) {
  auto values = values_over_starts(folder, statistic);
  if (values.empty()) throw SceneError(fmt::format("--y {}: no start has a value", statistic));
  const auto unit = fitting_unit(number_of_run(statistic).unit, Limits(values).size());
  for (double& x : values) x /= unit.size;
  const auto of_starts = interval(values);
  const auto classes =
      of_starts.greatest > of_starts.least
          ? std::min(most_classes,
                     static_cast<std::size_t>(std::ceil(2 * std::cbrt(static_cast<double>(values.size())))))
          : std::size_t{1};
  const double width = classes > 1 ? (of_starts.greatest - of_starts.least) / static_cast<double>(classes)
                                   : std::max(0.1 * std::abs(of_starts.least), 1e-12),
               from = classes > 1 ? of_starts.least : of_starts.least - 0.5 * width;
  std::vector<long> counts(classes, 0);
  for (const double x : values) ++counts[std::min(classes - 1, static_cast<std::size_t>((x - from) / width))];
  Block bars(fmt::format("{}: middle of the class, number of starts, width of the class", statistic));
  for (std::size_t k = 0; k < classes; ++k)
    bars.row({from + (static_cast<double>(k) + 0.5) * width, static_cast<double>(counts[k]), width});
  const double top = 1.15 * static_cast<double>(*std::ranges::max_element(counts));
  const bool known = std::isfinite(of_starts.low);
  Block mean(fmt::format("{}: mean and its 95 % interval, at the top of the panel", statistic));
  mean.row({of_starts.mean, 0.93 * top, known ? of_starts.low : of_starts.mean,
            known ? of_starts.high : of_starts.mean});
  Limits across({from, from + width * static_cast<double>(classes)});
  if (known) across.hold(of_starts.low), across.hold(of_starts.high);
  const double margin = 0.03 * across.range();
  Axis up{0, top};
  up.whole = true;
  Panel panel{
      .title = AxisTitle::of("number of starts", ""),
      .axis = up,
      .curves = {{Script().add("DATA index {} using 1:2:3 with boxes lc rgb C1 fs solid 0.35 border",
                               f.blocks.size()),
                  ""},
                 {Script().add("DATA index {} using 1:2:3:4 with xerrorbars lc rgb C2 lw 1.6 pt 7 ps 0.8",
                               f.blocks.size() + 1),
                  known ? fmt::format("mean {:.4g} ± {:.2g} (95 %)", of_starts.mean,
                                      0.5 * (of_starts.high - of_starts.low))
                        : fmt::format("{:.4g}, one start", of_starts.mean)}},
      .abscissa =
          Abscissa{title_of_number(statistic, unit.name), {across.least - margin, across.most + margin}}};
  f.caption += fmt::format("{}{}: {} starts.", f.caption.empty() ? "" : " ", statistic, values.size());
  f.blocks.push_back(std::move(bars));
  f.blocks.push_back(std::move(mean));
  return panel;
}

}  // namespace

std::filesystem::path draw_ensemble_of(const StudyPlot& plot) {
  if (!plot.x.empty()) throw SceneError("--x: an ensemble has no axes");
  const auto bands = bands_of_ensemble(plot.folder), statistics = statistics_of_ensemble(plot.folder);
  const auto has = [](const std::vector<std::string>& list, const std::string& name) {
    return std::ranges::find(list, name) != list.end();
  };
  std::size_t over_time = 0;
  for (const auto& name : plot.y) {
    if (!has(bands, name) && !has(statistics, name))
      throw SceneError("--y: " + unknown_name("column or statistic", name,
                                              {{"bands", bands}, {"statistics", statistics}}));
    over_time += has(bands, name);
  }
  Figure f{.name = name_of_plot(plot, "ensemble"),
           .source = "ensemble.json",
           .title = plot.title,
           .formats = plot.formats};
  if (over_time == plot.y.size()) {
    if (plot.y.size() > most_bands)
      throw SceneError(fmt::format("{} columns, but a figure has at most {} panels; draw several figures",
                                   plot.y.size(), most_bands));
    f.caption = fmt::format("{}: quantiles of the starts over time.", fmt::join(plot.y, ", "));
    add_bands(f, plot.folder, plot.y);
    return draw(f, plot.folder);
  }
  if (over_time > 0)
    throw SceneError("--y: names columns over time and statistics of starts; draw them in two figures");
  if (plot.y.size() > most_histograms)
    throw SceneError(fmt::format("{} statistics, but a figure has at most {} panels; draw several figures",
                                 plot.y.size(), most_histograms));
  PanelStack stack{.abscissa = {}, .panels = {}, .each = 4.0};
  for (const auto& name : plot.y) stack.panels.push_back(histogram(f, plot.folder, name));
  return draw_panels(f, plot.folder, std::move(stack));
}

// Chosen columns of a bifurcation diagram over its parameter, and of a basin over its grid.

namespace {

struct SectionColumn {
  std::string name, unit;
};

/// Columns of the section of a bifurcation or basin, and the period of its attractors.
std::vector<SectionColumn> columns_of_attractors(const JsonFile& document, const std::string& kind) {
  std::vector<SectionColumn> list;
  const auto* columns = document.find(kind + ".columns");
  for (std::size_t i = 0; columns && i < columns->size(); ++i) {
    const auto path = fmt::format("{}.columns.{}.", kind, i);
    list.push_back({document.text(path + "name"), document.text_or_empty(path + "unit")});
  }
  list.push_back({"period", ""});
  if (document.find(kind + ".exponent_periods")) list.push_back({"exponent", "1/s"});
  return list;
}

SectionColumn known_column(const std::vector<SectionColumn>& all, const std::string& name) {
  const auto it = std::ranges::find(all, name, &SectionColumn::name);
  if (it != all.end()) return *it;
  std::vector<std::string> names;
  for (const auto& c : all) names.push_back(c.name);
  throw SceneError("--y: " + unknown_name("column", name, {{"columns", names}}));
}

void refuse_axes(const StudyPlot& plot, const char* what) {
  if (!plot.x.empty()) throw SceneError(fmt::format("--x: the axes of {} are those of its study", what));
}

AxisTitle axis_of_document(const JsonFile& document, const std::string& path) {
  return AxisTitle::plain(document.text(path + ".name"), document.text_or_empty(path + ".unit"));
}

}  // namespace

std::filesystem::path draw_bifurcation_of(const StudyPlot& plot) {
  refuse_axes(plot, "a bifurcation diagram");
  if (plot.y.size() != 1)
    throw SceneError("--y: a bifurcation diagram shows one column; draw several figures");
  const JsonFile document(plot.folder / "bifurcation.json");
  const auto column = known_column(columns_of_attractors(document, "bifurcation"), plot.y.front());
  Figure f{.name = name_of_plot(plot, "bifurcation"),
           .height_cm = 10,
           .source = "bifurcation.json",
           .title = plot.title,
           .formats = plot.formats};
  if (!add_bifurcation(f, plot.folder, column.name, column.unit))
    throw SceneError(plot.folder.string() + ": contains no run of a bifurcation diagram");
  return draw(f, plot.folder);
}

std::filesystem::path draw_basin_of(const StudyPlot& plot) {
  refuse_axes(plot, "a basin");
  const JsonFile document(plot.folder / "basin.json");
  const auto all = columns_of_attractors(document, "basin");
  HeatMap map{.x = axis_of_document(document, "basin.x"),
              .y = axis_of_document(document, "basin.y"),
              .grid = true,
              .heading = "x, y, value at the last section point",
              .panels = {}};
  for (const auto& name : plot.y) {
    const auto column = known_column(all, name);
    const ReadTable table(plot.folder / "basin.csv", {}, {"x", "y", column.name});
    auto& panel = map.panels.emplace_back(HeatPanel{
        "", name_with_unit(column.name, column.unit), title_of_column(column.name, column.unit), {}});
    for (std::size_t i = 0; i < table.rows(); ++i)
      panel.cells.push_back({table.column("x")[i], table.column("y")[i], table.column(column.name)[i]});
  }
  Figure f{.name = name_of_plot(plot, "basin"),
           .source = "basin.json",
           .title = plot.title,
           .formats = plot.formats};
  f.caption = fmt::format("{} of the attractor reached from each start.", fmt::join(plot.y, ", "));
  if (map.panels.size() == 1) f.width_cm = 13;
  add_heat_map(f, map, style_of(plot.folder));
  return draw(f, plot.folder);
}

}  // namespace freeplay::plots
