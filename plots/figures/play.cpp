// Output play: the range of each output about its ideal curve y over the driven coordinate, and the parts of
// the joints in its width.
//
// play_band_* shows above the ideal curve with the range magnified by a round factor M,
//
//     y + M (least − y)  to  y + M (greatest − y),
//
// because the range is far narrower than the changes of y; the greatest width is about a tenth of the axis.
// Below are the deviations least − y and greatest − y with the linear range. play_parts_* shows greatest −
// least as the stacked parts of the joints. Curves have gaps where the analysis refuses a range.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>
#include <numbers>
#include <numeric>
#include <utility>

#include "io/files/input_file.hpp"
#include "mechanism/error.hpp"
#include "plots/drawing/column_title.hpp"
#include "plots/drawing/figure.hpp"
#include "plots/drawing/panels.hpp"
#include "plots/tables/columns.hpp"
#include "plots/tables/table.hpp"

namespace freeplay::plots {
namespace {

/// Bounds are drawn if they are farther from the values found than this share of the deviations' range.
constexpr double visible_gap = 0.005;
/// A joint whose part stays below this share of the greatest width has no layer of its own.
constexpr double visible_part = 0.002;

/// Colours of the layers from the bottom, and densities that distinguish neighbours without colours.
struct LayerLook {
  Word colour, density;
};
constexpr LayerLook layer_looks[] = {{"C1", "0.75"}, {"C2", "0.2"}, {"C4", "0.5"},  {"C5", "0.05"},
                                     {"C6", "0.65"}, {"C7", "0.3"}, {"C8", "0.45"}, {"C9", "0.12"}};
constexpr std::size_t most_layers = std::size(layer_looks);

/// The driven coordinate of the positions.
struct Driven {
  std::string joint;
  ShownUnit unit;
  std::vector<double> values;  ///< in this unit
  Abscissa abscissa;
};

/// The range of an output at a position; NaN if it is refused.
struct OutputRange {
  double ideal, least, greatest, bound_least, bound_greatest, linear;
};

struct Output {
  std::string name, column, si;  ///< column: its name in the tables
  std::vector<OutputRange> ranges;
  double width = 0;  ///< the greatest one
};

Driven driven_in(const std::filesystem::path& folder, const JsonFile& facts) {
  Driven driven{.joint = facts.text("joint"), .unit = {}, .values = {}, .abscissa = {}};
  if (driven.joint.empty()) return driven;
  driven.values = ReadTable(folder / "play.csv", {}, {driven.joint}).column(driven.joint);
  const bool turns = facts.text("unit") == "rad";
  driven.unit =
      turns ? ShownUnit{"°", std::numbers::pi / 180} : fitting_unit("m", Limits(driven.values).size());
  for (auto& value : driven.values) value /= driven.unit.size;
  const Limits limits(driven.values);
  const Word quantity = turns ? Word("angle") : Word("position");
  driven.abscissa.title =
      AxisTitle::of(driven.joint, Script().add("'{}'", quantity), letters(quantity.text()), driven.unit.name);
  constexpr double least_turn = 60;  // degrees; a shorter axis has too few parts of a turn
  driven.abscissa.axis = {limits.least, limits.most};
  driven.abscissa.axis.turn = turns && limits.range() >= least_turn;
  return driven;
}

Output output_in(const std::filesystem::path& folder, const JsonFile& facts, std::size_t k) {
  const auto at = fmt::format("quantities.{}.", k);
  Output y{facts.text(at + "quantity"), facts.text(at + "column"), facts.text(at + "unit"), {}};
  Rows rows(folder / "play.csv");
  const auto ideal = rows.place(y.column + ".ideal"), least = rows.place(y.column + ".least"),
             greatest = rows.place(y.column + ".greatest"), low = rows.place(y.column + ".bound_least"),
             high = rows.place(y.column + ".bound_greatest"), linear = rows.place(y.column + ".linear");
  while (rows.next()) {
    y.ranges.push_back({rows.maybe_number(ideal), rows.maybe_number(least), rows.maybe_number(greatest),
                        rows.maybe_number(low), rows.maybe_number(high), rows.maybe_number(linear)});
    y.width = std::fmax(y.width, y.ranges.back().greatest - y.ranges.back().least);
  }
  return y;
}

/// Whether clearances change the output by more than rounding errors do.
bool has_play(const Output& y) {
  Limits size;
  for (const auto& r : y.ranges) size.hold(r.ideal);
  constexpr double rounding = 1e-12;
  return y.width > 0 && y.width > rounding * size.size();
}

/// The rows of the positions that have a range, with a gap for others. `of(i)`: the numbers of position i.
Block block_of(const std::string& heading, const Driven& driven, const Output& y, auto of) {
  Block block(heading);
  bool refused = false;
  for (std::size_t i = 0; i < y.ranges.size(); ++i) {
    if (!std::isfinite(y.ranges[i].ideal)) {
      refused = true;
      continue;
    }
    if (std::exchange(refused, false) && !block.empty()) block.gap();
    std::vector<double> row{driven.values[i]};
    for (const double x : of(i)) row.push_back(x);
    block.row(row);
  }
  return block;
}

/// What the figure shows, between which positions, and how many have no range.
std::string caption_of(const std::string& what, const Driven& driven, const Output& y) {
  const Limits over(driven.values);
  const auto refused =
      std::ranges::count_if(y.ranges, [](const OutputRange& range) { return !std::isfinite(range.ideal); });
  return fmt::format(
      "{} within the clearances over {} from {:.4g} to {:.4g} {}.{}", what, driven.joint, over.least,
      over.most, driven.unit.name,
      refused > 0 ? fmt::format(" No range at {} of {} positions.", refused, y.ranges.size()) : "");
}

AxisTitle title_of_output(const Output& y, const std::string& unit) {
  const bool is_coordinate = y.name.find('.') != y.name.npos && unit_of_column(y.name) == y.si;
  return is_coordinate ? title_of_column(y.name, unit) : AxisTitle::plain(y.name, unit);
}

PanelCurve curve(Word columns, Word look, std::string title = "") {
  return {Script().add("DATA index 0 using {} with {}", columns, look), std::move(title)};
}

std::filesystem::path draw_band(const std::filesystem::path& folder, const Driven& driven, const Output& y) {
  Limits ideal, band, deviation, bounds;
  double gap = 0;
  for (const auto& r : y.ranges) {
    ideal.hold(r.ideal);
    for (const double x : {r.least - r.ideal, r.greatest - r.ideal, -r.linear, r.linear}) deviation.hold(x);
    bounds.hold(r.bound_least - r.ideal), bounds.hold(r.bound_greatest - r.ideal);
    for (const double x : {r.least - r.bound_least, r.bound_greatest - r.greatest})
      if (std::isfinite(x)) gap = std::max(gap, x);
  }
  const bool bounded = gap > visible_gap * deviation.range();
  if (bounded) deviation.hold(bounds.least), deviation.hold(bounds.most);
  // A constant has no scale for a magnification.
  const auto axis = axis_of(ideal.least, ideal.most);
  const double factor = ideal.range() > y.width ? round_factor(0.1 * (axis.high - axis.low) / y.width) : 1;
  const auto magnified = [&](const OutputRange& r, double x) { return r.ideal + factor * (x - r.ideal); };
  for (const auto& r : y.ranges) band.hold(magnified(r, r.least)), band.hold(magnified(r, r.greatest));
  const auto unit = fitting_unit(y.si, band.size()), small = fitting_unit(y.si, deviation.size());

  Figure f{.name = file_name("play_band", y.name), .source = "play.json"};
  f.caption = caption_of(
      factor > 1 ? fmt::format("Ideal {} with its range magnified {:.0f} times, and deviations from it",
                               y.name, factor)
                 : fmt::format("Ideal {} with its range, and deviations from it", y.name),
      driven, y);
  f.blocks.push_back(
      block_of(fmt::format("{} ({}); {} ({}): ideal, range times {:.0f}; deviations ({}): least, greatest, "
                           "linear, bounds",
                           driven.joint, driven.unit.name, y.name, unit.name, factor, small.name),
               driven, y, [&](std::size_t i) {
                 const auto& r = y.ranges[i];
                 std::vector<double> row;
                 for (const double x : {r.ideal, magnified(r, r.least), magnified(r, r.greatest)})
                   row.push_back(x / unit.size);
                 for (const double x : {r.least - r.ideal, r.greatest - r.ideal, -r.linear, r.linear,
                                        r.bound_least - r.ideal, r.bound_greatest - r.ideal})
                   row.push_back(std::isfinite(x) ? x / small.size : NAN);
                 return row;
               }));
  const double margin = 0.05 * band.range() / unit.size;
  Panel above{.title = title_of_output(y, unit.name),
              .axis = factor > 1 ? axis_of(band.least / unit.size, band.most / unit.size)
                                 : Axis{band.least / unit.size - margin, band.most / unit.size + margin},
              .curves = {curve("1:3:4", "filledcurves lc rgb C1",
                               factor > 1 ? fmt::format("range × {:.0f}", factor) : "range"),
                         curve("1:2", "lines lw 1.2 lc rgb C3", "ideal")}};
  constexpr Word found = "lines lw 2.2 lc rgb C1", linear = "lines lw 0.8 lc rgb C2",
                 bound = "lines lw 1.2 dt (2,3) lc rgb C4";
  Panel below{.title = AxisTitle::of("deviation from ideal", small.name),
              .axis = axis_of(deviation.least / small.size, deviation.most / small.size),
              .curves = {curve("1:5:6", "filledcurves lc rgb C1"), curve("1:5", found, "extremes"),
                         curve("1:6", found), curve("1:7", linear, "linear"), curve("1:8", linear)}};
  if (bounded) {
    below.curves.push_back(curve("1:9", bound, "bounds"));
    below.curves.push_back(curve("1:10", bound));
  }
  f.script.add("set style fill transparent solid 0.25 noborder\n");
  return draw_panels(
      f, folder, {.abscissa = driven.abscissa, .panels = {std::move(above), std::move(below)}, .each = 3.8});
}

/// The part of a joint, or of several, at each position.
struct Layer {
  std::string name;
  std::vector<double> parts;
  double size() const { return Limits(parts).size(); }
};

/// The parts of the joints in the k-th of `outputs` outputs, in the order of the file.
std::vector<Layer> layers_in(const std::filesystem::path& folder, const Output& y, std::size_t k,
                             std::size_t outputs) {
  Rows rows(folder / "play_parts.csv");
  const auto joints = (rows.names().size() - 1) / outputs, first = 1 + k * joints;
  std::vector<Layer> layers;
  for (std::size_t j = 0; j < joints; ++j) {
    const auto& name = rows.names()[first + j];
    if (!name.starts_with(y.column + "."))
      throw SceneError(fmt::format("{}:1: column {} must be a part of {}",
                                   (folder / "play_parts.csv").string(), name, y.column));
    layers.push_back({name.substr(y.column.size() + 1), {}});
  }
  while (rows.next())
    for (std::size_t j = 0; j < joints; ++j) layers[j].parts.push_back(rows.maybe_number(first + j));
  if (layers.empty() || layers.front().parts.size() != y.ranges.size())
    throw SceneError(fmt::format("{}: must have the parts of joints at the positions of play.csv",
                                 (folder / "play_parts.csv").string()));
  return layers;
}

/// The visible layers, at most `most_layers`: the smallest ones together are the last layer.
std::vector<Layer> merged(const std::vector<Layer>& layers, double width) {
  std::vector<std::size_t> order(layers.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, std::ranges::greater{}, [&](std::size_t j) { return layers[j].size(); });
  if (order.size() > most_layers) order.resize(most_layers - 1);
  std::vector<Layer> list;
  Layer others{"others", std::vector<double>(layers.front().parts.size())};
  for (std::size_t j = 0; j < layers.size(); ++j)
    if (layers[j].size() >= visible_part * width && std::ranges::find(order, j) != order.end())
      list.push_back(layers[j]);
    else
      std::ranges::transform(others.parts, layers[j].parts, others.parts.begin(), std::plus{});
  if (others.size() >= visible_part * width) list.push_back(std::move(others));
  return list;
}

std::filesystem::path draw_parts(const std::filesystem::path& folder, const Driven& driven, const Output& y,
                                 const std::vector<Layer>& layers) {
  const auto unit = fitting_unit(y.si, y.width);
  Figure f{.name = file_name("play_parts", y.name), .source = "play.json"};
  f.caption = caption_of(fmt::format("Range of {} with the parts of the joints", y.name), driven, y);
  std::string heading =
      fmt::format("{} ({}); {} ({}): 0, then the sums of", driven.joint, driven.unit.name, y.name, unit.name);
  for (const auto& layer : layers) heading += " " + layer.name;
  Limits sums;
  f.blocks.push_back(block_of(heading, driven, y, [&](std::size_t i) {
    std::vector<double> row{0};
    for (const auto& layer : layers) row.push_back(row.back() + layer.parts[i] / unit.size);
    for (const double x : row) sums.hold(x);
    return row;
  }));
  Panel panel{.title = AxisTitle::of(y.name, Script().add("'range'"), letters("range"), unit.name),
              .axis = {},
              .curves = {}};
  for (std::size_t j = 0; j < layers.size(); ++j) {
    const auto& look = layer_looks[j];
    panel.curves.push_back({Script().add("DATA index 0 using 1:{}:{} with filledcurves fs solid (MONO ? {} : "
                                         "0.65) noborder lc rgb {}",
                                         j + 2, j + 3, look.density, look.colour),
                            layers[j].name});
  }
  for (std::size_t j = 0; j < layers.size(); ++j)
    panel.curves.push_back({Script().add("DATA index 0 using 1:{} with lines lw {} lc rgb C3", j + 3,
                                         j + 1 < layers.size() ? Word("0.5") : Word("1.2")),
                            ""});
  panel.axis = axis_of(sums.least, sums.most);
  return draw_panels(f, folder, {.abscissa = driven.abscissa, .panels = {std::move(panel)}, .each = 5.5});
}

std::vector<std::filesystem::path> draw_play(const std::filesystem::path& folder) {
  const JsonFile facts(folder / "play.json");
  const auto driven = driven_in(folder, facts);
  if (!(Limits(driven.values).range() > 0)) return {};  // a single position
  const auto* outputs = facts.find("quantities");
  if (!outputs || !outputs->is_array()) facts.fail("quantities", "must be a list");
  std::vector<std::filesystem::path> made;
  for (std::size_t k = 0; k < outputs->size(); ++k) {
    const auto y = output_in(folder, facts, k);
    if (!has_play(y)) continue;
    made.push_back(draw_band(folder, driven, y));
    const auto layers = merged(layers_in(folder, y, k, outputs->size()), y.width);
    if (!layers.empty()) made.push_back(draw_parts(folder, driven, y, layers));
  }
  return made;
}

}  // namespace

const Drawing play{{"play.json"}, draw_play};

}  // namespace freeplay::plots
