// Figures of a study of the test matrix (axes clearance and speed). They show the content of
// figures 5 to 13 of Flores et al. 2011 as computed by the model in both formulations, with the
// measured values stated in the text of the paper; `figures --paper` draws them by its numbers. The
// velocity is the difference quotient of the position signal,
//
//     v_i = (x_{i+1} − x_{i−1}) n/60 · 360/(φ_{i+1} − φ_{i−1}),    n: rpm, φ: degrees of the crank.

#include "plots/figures/experiment.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "mechanism/error.hpp"
#include "plots/drawing/axis.hpp"
#include "plots/drawing/figure.hpp"
#include "plots/drawing/heat_map.hpp"
#include "plots/drawing/panels.hpp"
#include "plots/tables/table.hpp"
#include "values/family.hpp"

namespace freeplay::plots {
namespace {

struct Key {
  std::string formulation;
  double clearance, speed;
  auto operator<=>(const Key&) const = default;
};

/// Selected columns of one variant of a table, by formulation and cell.
using Cells = std::map<Key, std::vector<std::vector<double>>>;

/// A quantity of a table of cells: its column after the abscissa.
struct CellQuantity {
  AxisTitle title;
  std::size_t column;
  bool spectrum = false;
};
CellQuantity acceleration_shown() { return {AxisTitle::of("acceleration", "m/s²"), 1}; }
CellQuantity position_shown() { return {AxisTitle::of("position", "m"), 2}; }
CellQuantity velocity_shown() { return {AxisTitle::of("velocity", "m/s"), 3}; }
CellQuantity amplitude_shown() { return {AxisTitle::of("amplitude", "m/s²"), 1, true}; }

/// Numbers of the figures in the paper.
constexpr std::pair<std::string_view, int> paper_numbers[] = {
    {"positions", 5}, {"clearances", 6},    {"clearance_spectra", 7},
    {"speeds", 8},    {"speed_spectra", 9}, {"peaks_clearance", 10},
    {"motions", 11},  {"peaks_speed", 12},  {"surface", 13}};
constexpr std::size_t most_cells = 4;  ///< clearances or speeds of a figure
constexpr const char* measured_source =
    " Measured: the values that the text of Flores et al. (2011), Nonlinear Dynamics 65, 383-398, states.";

class Experiment {
 public:
  /// With `paper`, the JSON file of the provenance, figures have the numbers of the paper.
  Experiment(const std::filesystem::path& folder, const std::string& variant, const std::string& paper = "")
      : folder_(folder), variant_(variant), paper_(paper) {
    traces_ = read("traces.csv", {"angle", "acceleration", "position"}, "");
    for (auto& [key, turn] : traces_) add_velocity(turn, key.speed);
    spectra_ = read("spectra.csv", {"harmonic", "amplitude"}, "");
    peaks_ = read("cells.csv", {"mean", "low", "high"}, "ratio_95");
    greatest_ = read("cells.csv", {"mean", "low", "high"}, "peak_95");
    for (const auto& [key, rows] : peaks_) {
      if (std::ranges::find(clearances_, key.clearance) == clearances_.end())
        clearances_.push_back(key.clearance);
      if (std::ranges::find(speeds_, key.speed) == speeds_.end()) speeds_.push_back(key.speed);
    }
    if (peaks_.empty())
      throw SceneError(fmt::format("{}: has no row of variant {} with statistic ratio_95",
                                   (folder / "cells.csv").string(), variant));
    std::ranges::sort(clearances_);
    std::ranges::sort(speeds_);
  }

  std::vector<std::filesystem::path> all() {
    return {motion(),
            panels("clearances", true, acceleration_shown()),
            panels("clearance_spectra", true, amplitude_shown()),
            panels("speeds", false, acceleration_shown()),
            panels("speed_spectra", false, amplitude_shown()),
            velocities(),
            peaks_by_clearance(),
            peaks_by_speed(),
            surface()};
  }
  std::vector<std::filesystem::path> numbered() {
    return {positions(),
            panels("clearances", true, acceleration_shown()),
            panels("clearance_spectra", true, amplitude_shown()),
            panels("speeds", false, acceleration_shown()),
            panels("speed_spectra", false, amplitude_shown()),
            peaks_by_clearance(),
            motions(),
            peaks_by_speed(),
            surface()};
  }

 private:
  Cells read(const std::string& file, const std::vector<std::string>& columns,
             const std::string& statistic) const {
    std::vector<std::string> names{"variant", "formulation"}, numbers{"clearance", "speed"};
    if (!statistic.empty()) names.emplace_back("statistic");
    numbers.insert(numbers.end(), columns.begin(), columns.end());
    const ReadTable table(folder_ / file, names, numbers);
    const auto &clearance = table.column("clearance"), &speed = table.column("speed");
    Cells cells;
    for (std::size_t i = 0; i < table.rows(); ++i) {
      if (table.text("variant")[i] != variant_ ||
          (!statistic.empty() && table.text("statistic")[i] != statistic))
        continue;
      auto& row = cells[{table.text("formulation")[i], clearance[i], speed[i]}].emplace_back();
      for (const auto& c : columns) row.push_back(table.column(c)[i]);
    }
    return cells;
  }
  /// The velocity after the columns of a turn, by differences of the position over the angle.
  static void add_velocity(std::vector<std::vector<double>>& turn, double speed) {
    for (std::size_t i = 0; i < turn.size(); ++i) {
      const auto &before = turn[i > 0 ? i - 1 : i], &after = turn[std::min(i + 1, turn.size() - 1)];
      const double degrees = after[0] - before[0];
      turn[i].push_back(degrees > 0 ? (after[2] - before[2]) * speed / 60 * 360 / degrees : NAN);
    }
  }
  Figure begin(const char* what, const std::string& caption) const {
    if (paper_.empty())
      return {.name = fmt::format("experiment_{}", what), .source = "experiment.json", .caption = caption};
    const auto number =
        std::ranges::find(paper_numbers, what, &std::pair<std::string_view, int>::first)->second;
    return {.name = fmt::format("figure_{:02}", number),
            .source = paper_,
            .caption = fmt::format("Flores et al. (2011), figure {}. {}", number, caption)};
  }
  /// Adds a block and returns the beginning of its plot command.
  static Script data(Figure& f, const Block& block) {
    f.blocks.push_back(block);
    return Script().add("DATA index {}", f.blocks.size() - 1);
  }
  static double nearest(const std::vector<double>& list, double x) {
    return *std::ranges::min_element(list, {}, [x](double v) { return std::abs(v - x); });
  }
  double paper_speed() const { return nearest(speeds_, 200); }
  double paper_clearance() const { return nearest(clearances_, 0.25e-3); }

  static std::string clearance_text(double c) { return fmt::format("{:.2f} mm", 1e3 * c); }
  static std::string speed_text(double n) { return fmt::format("{:.0f} rpm", n); }
  /// "(a) " … for the panels of the paper.
  std::string letter(std::size_t i) const {
    return paper_.empty() ? "" : fmt::format("({}) ", static_cast<char>('a' + i));
  }

  static int line_of(std::string_view formulation) {
    return formulation == "ideal" ? 3 : formulation == "penalty" ? 1 : 2;
  }

  /// The panel of one cell: these formulations, drawn over the ideal mechanism.
  Panel panel(Figure& f, double c, double n, const CellQuantity& shown, const std::string& name,
              const std::vector<const char*>& formulations = {"ideal", "penalty", "nonsmooth"}) const {
    const auto& cells = shown.spectrum ? spectra_ : traces_;
    Panel panel{.title = shown.title, .axis = {}, .curves = {}, .name = name};
    Limits limits;
    for (const char* formulation : formulations) {
      const auto it = cells.find({formulation, c, n});
      if (it == cells.end()) continue;
      Block block(fmt::format("{}, clearance {} m, {} rpm: {}, value", formulation, c, n,
                              shown.spectrum ? "harmonic" : "crank angle (degrees)"));
      for (const auto& row : it->second) {
        block.row({row[0], row[shown.column]});
        if (!shown.spectrum || row[shown.column] > 0) limits.hold(row[shown.column]);
      }
      panel.curves.push_back({data(f, block).add(" using 1:2 with lines ls {}", line_of(formulation)), ""});
    }
    panel.axis = shown.spectrum ? decades_of(limits.least, limits.most) : axis_of(limits.least, limits.most);
    return panel;
  }

  /// Draws panels over the crank angle, or over the harmonic.
  std::filesystem::path draw_panels(Figure& f, std::vector<Panel> panels, std::size_t columns,
                                    bool spectrum = false) const {
    const Abscissa harmonics{AxisTitle::of("harmonic", ""), {0, 100}},
        turn{crank_title(), {.low = 0, .high = 360, .turn = true}};
    std::vector<PanelCurve> key;
    for (const char* formulation : {"ideal", "penalty", "nonsmooth"})
      if (!spectrum || formulation != std::string_view("ideal"))
        key.push_back({Script().add("with lines ls {}", line_of(formulation)), formulation});
    add_panels(f, style_of(folder_),
               {.abscissa = spectrum ? harmonics : turn,
                .panels = std::move(panels),
                .each = 3.8,
                .columns = columns,
                .key = std::move(key)});
    return draw(f, folder_);
  }

  /// Adds one point with its interval, after the columns `before`.
  static void add_point(const Cells& cells, const Key& key, std::vector<double> before, Block& block) {
    const auto it = cells.find(key);
    if (it == cells.end()) return;
    for (auto row : it->second) {
      row.insert(row.begin(), before.begin(), before.end());
      block.row(row);
    }
  }

  std::filesystem::path motion() {
    const double c = paper_clearance(), n = paper_speed();
    auto f = begin("motion", fmt::format("Position and acceleration of the slider, clearance {}, {}.",
                                         clearance_text(c), speed_text(n)));
    return draw_panels(f, {panel(f, c, n, position_shown(), ""), panel(f, c, n, acceleration_shown(), "")},
                       1);
  }

  std::filesystem::path positions() {
    const double c = paper_clearance(), n = paper_speed();
    auto f =
        begin("positions",
              fmt::format("Position and acceleration of the slider in the last turn at {}, with the ideal "
                          "joint and with a clearance of {}.",
                          speed_text(n), clearance_text(c)));
    std::vector<Panel> list;
    for (const auto& shown : {position_shown(), acceleration_shown()}) {
      list.push_back(panel(f, c, n, shown, letter(list.size()) + "ideal", {"ideal"}));
      list.push_back(
          panel(f, c, n, shown, letter(list.size()) + clearance_text(c), {"penalty", "nonsmooth"}));
    }
    const auto &ideal = list[0].axis, &loose = list[1].axis;
    list[0].axis = list[1].axis = {std::min(ideal.low, loose.low), std::max(ideal.high, loose.high)};
    return draw_panels(f, std::move(list), 2);
  }

  std::filesystem::path motions() {
    const double n = paper_speed();
    auto f = begin("motions",
                   fmt::format("Velocity v and acceleration a of the slider in the last turn at {}, for "
                               "each clearance. The velocity is the difference quotient of the position.",
                               speed_text(n)));
    // Symbols leave room for two columns in a narrow figure.
    auto v = velocity_shown(), a = acceleration_shown();
    v.title = AxisTitle::of({"v", "$v$"}, "m/s"), a.title = AxisTitle::of({"a", "$a$"}, "m/s²");
    std::vector<Panel> list;
    for (std::size_t i = 0; i < std::min(clearances_.size(), most_cells); ++i)
      for (const auto& shown : {v, a})
        list.push_back(
            panel(f, clearances_[i], n, shown, letter(list.size()) + clearance_text(clearances_[i])));
    return draw_panels(f, std::move(list), 2);
  }

  std::filesystem::path panels(const char* what, bool along_clearance, const CellQuantity& shown) {
    const double c = paper_clearance(), n = paper_speed();
    auto f = begin(what, fmt::format("{} of the slider for each {}, {}.",
                                     shown.spectrum ? "Spectrum over the harmonics of the crank, acceleration"
                                                    : "Acceleration",
                                     along_clearance ? "clearance" : "crank speed",
                                     along_clearance ? speed_text(n) : "clearance " + clearance_text(c)));
    const auto& values = along_clearance ? clearances_ : speeds_;
    std::vector<Panel> list;
    for (std::size_t i = 0; i < std::min(values.size(), most_cells); ++i)
      list.push_back(
          panel(f, along_clearance ? values[i] : c, along_clearance ? n : values[i], shown,
                letter(i) + (along_clearance ? clearance_text(values[i]) : speed_text(values[i]))));
    return draw_panels(f, std::move(list), 2, shown.spectrum);
  }

  std::filesystem::path velocities() {
    const double n = paper_speed();
    auto f = begin("velocity", fmt::format("Velocity of the slider at {}, for the two greatest clearances.",
                                           speed_text(n)));
    std::vector<Panel> list;
    for (std::size_t i = clearances_.size() - std::min<std::size_t>(clearances_.size(), 2);
         i < clearances_.size(); ++i)
      list.push_back(panel(f, clearances_[i], n, velocity_shown(), clearance_text(clearances_[i])));
    return draw_panels(f, std::move(list), 1);
  }

  /// Means with their intervals in a logarithmic panel, and the measured points. The title of the
  /// points states whether the fit used them.
  std::filesystem::path peaks(Figure& f, Panel panel, const std::vector<std::pair<double, double>>& measured,
                              Abscissa abscissa, Limits limits) const {
    Block block("measured");
    for (const auto& [x, y] : measured) {
      block.row({x, y});
      limits.hold(y);
    }
    panel.curves.push_back({data(f, block).add(" using 1:2 with points pt 7 ps 1.2 lc rgb C3"),
                            variant_ == "calibrated" ? "measured, used in the fit" : "measured"});
    panel.axis = decades_of(limits.least, limits.most);
    add_panels(f, style_of(folder_),
               {.abscissa = std::move(abscissa), .panels = {std::move(panel)}, .each = 7.0});
    return draw(f, folder_);
  }

  /// Adds the means and intervals of one curve. The abscissae are shifted in the figure only, to
  /// separate the two formulations.
  static void add_means(Figure& f, Panel& panel, const Block& block, Family family, double shift,
                        const Script& colour, const std::string& title) {
    const bool penalty = family == Family::penalty;
    panel.curves.push_back(
        {data(f, block).add(" using ($1{}{}):2:3:4 with yerrorlines ls {}{}", penalty ? Word("-") : Word("+"),
                            shift, penalty ? 1 : 2, colour),
         title});
  }

  /// Holds the means and the upper ends of the intervals; lower ends may be negative.
  static void hold(Limits& limits, const Cells& cells, const Key& key) {
    const auto it = cells.find(key);
    if (it == cells.end()) return;
    for (const auto& row : it->second) limits.hold(row[0]), limits.hold(row[2]);
  }

  std::filesystem::path peaks_by_clearance() {
    auto f =
        begin("peaks_clearance",
              fmt::format("Greatest acceleration over that of the ideal mechanism at {}: 95 % quantile over "
                          "the turns, mean over the starts with its 95 % interval.{}",
                          speed_text(paper_speed()), measured_source));
    Panel panel{.title = AxisTitle::of("greatest acceleration / ideal", ""), .axis = {}, .curves = {}};
    Limits limits;
    for (const auto& [family, formulation] : families) {
      Block block("clearance, mean, low, high");
      for (const double c : clearances_) {
        add_point(peaks_, {formulation, c, paper_speed()}, {1e3 * c}, block);
        hold(limits, peaks_, {formulation, c, paper_speed()});
      }
      add_means(f, panel, block, family, 0.004, {}, formulation);
    }
    return peaks(f, std::move(panel), {{0.10, 3.5}, {0.25, 4}, {1.00, 20}},  // X7, X6, X8
                 {AxisTitle::of("clearance", "mm"), {0, 1.1e3 * clearances_.back()}}, limits);
  }

  std::filesystem::path peaks_by_speed() {
    constexpr Word colours[] = {" lc rgb C1", " lc rgb C2", " lc rgb C4", " lc rgb C5"};
    auto f =
        begin("peaks_speed",
              fmt::format("Greatest acceleration over the crank speed for each clearance: 95 % quantile over "
                          "the turns, mean over the starts with its 95 % interval.{} They hold for 0.10, "
                          "0.25 and 1.00 mm, from below.",
                          measured_source));
    Panel panel{.title = AxisTitle::of("greatest acceleration", "m/s²"), .axis = {}, .curves = {}};
    Limits limits;
    for (const auto& [family, formulation] : families)
      panel.curves.push_back(
          {Script().add("keyentry with linespoints ls {} lc rgb 0x555555", family == Family::penalty ? 1 : 2),
           formulation});
    for (std::size_t i = 0; i < clearances_.size(); ++i)
      for (const auto& [family, formulation] : families) {
        Block block(fmt::format("{}, clearance {} m: speed, mean, low, high", formulation, clearances_[i]));
        for (const double n : speeds_) {
          add_point(greatest_, {formulation, clearances_[i], n}, {n}, block);
          hold(limits, greatest_, {formulation, clearances_[i], n});
        }
        add_means(f, panel, block, family, 1, Script().add("{}", colours[i % std::size(colours)]),
                  family == Family::penalty ? clearance_text(clearances_[i]) : "");
      }
    const double margin = std::max(0.06 * (speeds_.back() - speeds_.front()), 2.0);
    // X7, X6, X8 times r ω² (1 + r/l) = 25.59 m/s² of the ideal mechanism at 200 rpm.
    return peaks(f, std::move(panel), {{200, 89.6}, {200, 102.4}, {200, 511.8}},
                 {AxisTitle::of("crank speed", "rpm"), {speeds_.front() - margin, speeds_.back() + margin}},
                 limits);
  }

  std::filesystem::path surface() {
    auto f = begin("surface",
                   "Greatest acceleration over clearance and crank speed: 95 % quantile over the turns.");
    HeatMap map{.x = AxisTitle::of("clearance", "mm"),
                .y = AxisTitle::of("crank speed", "rpm"),
                .grid = true,
                .heading =
                    "clearance (mm), speed (rpm), 95 % quantile over revolutions of the greatest "
                    "acceleration (m/s^2), 95 % interval",
                .panels = {}};
    for (const auto& [family, formulation] : families) {
      auto& cells =
          map.panels
              .emplace_back(HeatPanel{formulation, "", AxisTitle::of("greatest acceleration", "m/s²"), {}})
              .cells;
      for (const double c : clearances_)
        for (const double n : speeds_)
          if (const auto it = greatest_.find({formulation, c, n}); it != greatest_.end()) {
            const auto& row = it->second.front();
            cells.push_back({1e3 * c, n, row[0], row[1], row[2]});
          }
    }
    add_heat_map(f, map, style_of(folder_));
    return draw(f, folder_);
  }

  std::filesystem::path folder_;
  std::string variant_, paper_;
  Cells traces_, spectra_, peaks_, greatest_;
  std::vector<double> clearances_, speeds_;
};

/// The variant of the tables that is drawn: "calibrated" if it exists, otherwise the first; "" for
/// tables without rows.
std::string variant_to_draw(const std::filesystem::path& folder) {
  const ReadTable table(folder / "cells.csv", {"variant"}, {});
  const auto& variants = table.text("variant");
  if (variants.empty()) return "";
  return std::ranges::find(variants, "calibrated") != variants.end() ? "calibrated" : variants.front();
}

std::vector<std::filesystem::path> draw_experiment(const std::filesystem::path& folder) {
  const auto variant = variant_to_draw(folder);
  if (variant.empty()) return {};
  return Experiment(folder, variant).all();
}

}  // namespace

std::vector<std::filesystem::path> draw_flores2011(const std::filesystem::path& folder,
                                                   const std::string& source) {
  const auto variant = variant_to_draw(folder);
  if (variant.empty())
    throw SceneError(fmt::format("{}: has no rows to draw", (folder / "cells.csv").string()));
  return Experiment(folder, variant, source).numbered();
}

namespace {

std::vector<std::filesystem::path> draw_paper(const std::filesystem::path& folder) {
  return draw_flores2011(folder, "paper.json");
}

}  // namespace

const Drawing experiment{{"experiment.json"}, draw_experiment};
const Drawing paper_figures{{"paper.json"}, draw_paper};

}  // namespace freeplay::plots
