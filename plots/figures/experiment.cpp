// Figures of a study of the test matrix (axes clearance and speed). They show the content of
// figures 5 to 13 of Flores et al. 2011 as computed by the model in both formulations, with the
// measured values stated in the text of the paper. paper.cpp draws them by the paper's numbers.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "mechanism/error.hpp"
#include "plots/drawing/figure.hpp"
#include "plots/figures/paper.hpp"
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

constexpr Word angles = "set xrange [0:360]\nset xtics 90\n";

/// Numbers of the figures in the paper.
constexpr std::pair<std::string_view, int> paper_numbers[] = {
    {"clearances", 6},       {"clearance_spectra", 7}, {"speeds", 8},  {"speed_spectra", 9},
    {"peaks_clearance", 10}, {"peaks_speed", 12},      {"surface", 13}};
constexpr Word paper_letters[] = {"(a) ", "(b) ", "(c) ", "(d) "};

class Experiment {
 public:
  /// With `paper`, the JSON file of the provenance, figures have the numbers of the paper.
  Experiment(const std::filesystem::path& folder, const std::string& variant, const std::string& paper = "")
      : folder_(folder), variant_(variant), paper_(paper) {
    traces_ = read("traces.csv", {"angle", "acceleration", "position"}, "");
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
            panels("clearances", true, false),
            panels("clearance_spectra", true, true),
            panels("speeds", false, false),
            panels("speed_spectra", false, true),
            velocities(),
            peaks_by_clearance(),
            peaks_by_speed(),
            surface()};
  }
  std::vector<std::filesystem::path> numbered() {
    return {panels("clearances", true, false),
            panels("clearance_spectra", true, true),
            panels("speeds", false, false),
            panels("speed_spectra", false, true),
            peaks_by_clearance(),
            peaks_by_speed(),
            surface()};
  }

 private:
  Cells read(const std::string& file, const std::vector<std::string>& columns,
             const std::string& statistic) const {
    std::vector<std::string> names{"variant", "formulation"}, numbers{"clearance", "speed"};
    if (!statistic.empty()) names.emplace_back("statistic");
    numbers.insert(numbers.end(), columns.begin(), columns.end());
    const Table table(folder_ / file, names, numbers);
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
  Figure begin(const char* what, double height) const {
    if (paper_.empty())
      return {.name = fmt::format("experiment_{}", what), .height_cm = height, .source = "experiment.json"};
    const auto* number = std::ranges::find(paper_numbers, what, &std::pair<std::string_view, int>::first);
    return {.name = fmt::format("figure_{:02}", number->second), .height_cm = height, .source = paper_};
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

  /// Adds the curves of one cell: both formulations, drawn over the ideal mechanism.
  static void add_curves(Figure& f, const Cells& cells, double c, double n, const Script& use, bool titles) {
    Script plot;
    const std::pair<const char*, int> styles[] = {{"ideal", 3}, {"penalty", 1}, {"nonsmooth", 2}};
    for (const auto& [formulation, line] : styles) {
      const auto it = cells.find({formulation, c, n});
      if (it == cells.end()) continue;
      Block block(fmt::format("{}, clearance {} m, {} rpm", formulation, c, n));
      for (const auto& row : it->second) block.row(row);
      plot.add("{}{} using {} with lines ls {} ", plot.empty() ? Word("plot ") : Word(", "), data(f, block),
               use, line);
      if (titles)
        plot.add("title {}", formulation);
      else
        plot.add("notitle");
    }
    f.script.add("{}\n", plot);
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
    auto f = begin("motion", 12);
    const double c = paper_clearance(), n = paper_speed();
    f.script.add(
        "set multiplot layout 2,1 margins X(1.9),1-X(0.5),Y(1.15),1-Y(1) spacing 0,Y(0.7)\n{}set key at screen "
        "1-X(0.5),1-Y(0.15) horizontal maxrows 1\nset format x ''\nset ylabel 'Position (m)'\nset label 1 '{:.2f} mm, {:.0f} "
        "rpm' at screen X(1.9),1-Y(0.45)\n",
        angles, 1e3 * c, n);
    add_curves(f, traces_, c, n, Script().add("1:3"), true);
    f.script.add(
        "unset key\nunset label 1\nset format x\nset xlabel 'Crank angle (°)'\nset ylabel 'Acceleration "
        "(m/s²)'\n");
    add_curves(f, traces_, c, n, Script().add("1:2"), false);
    f.script.add("unset multiplot\n");
    return draw(f, folder_);
  }

  std::filesystem::path panels(const char* what, bool along_clearance, bool spectrum) {
    auto f = begin(what, 13);
    f.script.add("set multiplot layout 2,2 margins X(1.8),1-X(0.4),Y(1.15),1-Y(1.3) spacing X(1.7),Y(2)\n");
    if (spectrum)
      f.script.add(
          "set logscale y\nset format y '%g'\nset xlabel 'Harmonic of the crank'\nset xrange "
          "[0:100]\n");
    else
      f.script.add("{}set xlabel 'Crank angle (°)'\n", angles);
    const auto& values = along_clearance ? clearances_ : speeds_;
    for (std::size_t i = 0; i < std::min<std::size_t>(values.size(), 4); ++i) {
      const double c = along_clearance ? values[i] : paper_clearance(),
                   n = along_clearance ? paper_speed() : values[i];
      f.script.add("set title '{}{:.2f} mm, {:.0f} rpm' offset 0,-0.8\n",
                   paper_.empty() ? Word("") : paper_letters[i], 1e3 * c, n);
      if (i % 2 == 0)
        f.script.add("set ylabel '{} (m/s²)'\n", spectrum ? Word("Amplitude") : Word("Acceleration"));
      else
        f.script.add("unset ylabel\n");
      f.script.add("{}\n", i == 0 ? Word("set key at screen 1-X(0.4),1-Y(0.15) horizontal maxrows 1")
                                  : Word("unset key"));
      add_curves(f, spectrum ? spectra_ : traces_, c, n, Script().add("1:2"), i == 0);
    }
    f.script.add("unset multiplot\n");
    return draw(f, folder_);
  }

  std::filesystem::path velocities() {
    auto f = begin("velocity", 12);
    f.script.add(
        "set multiplot layout 2,1 margins X(1.9),1-X(0.5),Y(1.15),1-Y(1.3) spacing 0,Y(1)\n{}set format x ''\nset "
        "ylabel 'Velocity (m/s)'\n",
        angles);
    const double n = paper_speed();
    // Finite differences of the position signal; the first sample of a curve has no value.
    const auto rate = Script().add(
        "1:(d = $3 - x0, s = ($1 - a0)/360*{}, x0 = $3, a0 = $1, (s > 0 && s < 0.01) ? d/s : 1/0)", 60 / n);
    const auto last = clearances_.size();
    for (std::size_t i = last >= 2 ? last - 2 : 0; i < last; ++i) {
      f.script.add("x0 = 0; a0 = 1e9\nset title '{:.2f} mm, {:.0f} rpm' offset 0,-0.8\n",
                   1e3 * clearances_[i], n);
      f.script.add("{}\n", i + 1 == last ? Word("set format x\nset xlabel 'Crank angle (°)'\nunset key")
                                         : Word("set key at screen 1-X(0.4),1-Y(0.15) horizontal maxrows 1"));
      add_curves(f, traces_, clearances_[i], n, rate, i + 1 != last);
    }
    f.script.add("unset multiplot\n");
    return draw(f, folder_);
  }

  /// Plot command of the measured points. The title states whether the fit used them.
  Script measured(Figure& f, const Block& block) const {
    return Script().add("{} using 1:2 with points pt 7 ps 1.4 lc rgb C3 title 'measured{}'\n", data(f, block),
                        variant_ == "calibrated" ? Word(", used in the fit") : Word(""));
  }

  std::filesystem::path peaks_by_clearance() {
    auto f = begin("peaks_clearance", 9);
    Script plot;
    for (const auto& [family, formulation] : families) {
      Block block("clearance, mean, low, high");
      const bool penalty = family == Family::penalty;
      for (double c : clearances_) add_point(peaks_, {formulation, c, paper_speed()}, {1e3 * c}, block);
      // The abscissae are shifted in the figure only, to separate the two formulations.
      plot.add("{} using ($1{}0.004):2:3:4 with yerrorlines ls {} title {}, ", data(f, block),
               penalty ? Word("-") : Word("+"), penalty ? 1 : 2, formulation);
    }
    plot.add("{}",
             measured(f, Block("measured: X7, X6, X8").row({0.10, 3.5}).row({0.25, 4}).row({1.00, 20})));
    f.script.add(
        "set logscale y\nset ylabel 'Greatest acceleration / ideal'\nset xlabel 'Clearance (mm)'\nset "
        "xrange [0:1.1]\nset yrange [1:100]\nset key outside top center horizontal\nplot {}",
        plot);
    return draw(f, folder_);
  }

  std::filesystem::path peaks_by_speed() {
    auto f = begin("peaks_speed", 9);
    Script plot;
    f.script.add(
        "set logscale y\nset ylabel 'Greatest acceleration (m/s²)'\nset xlabel 'Crank speed (rpm)'\nset "
        "xrange [90:252]\nset rmargin at screen 1-X(1.7)\nset key outside top center horizontal\n");
    for (double c : clearances_)
      for (const auto& [family, formulation] : families) {
        const bool penalty = family == Family::penalty;
        Block block("speed, mean, low, high");
        double end = NAN;
        for (double n : speeds_) {
          add_point(greatest_, {formulation, c, n}, {n}, block);
          if (const auto it = greatest_.find({formulation, c, n}); it != greatest_.end())
            end = it->second[0][0];
        }
        plot.add("{}{} using ($1{}1):2:3:4 with yerrorlines ls {} ",
                 plot.empty() ? Word("plot ") : Word(", "), data(f, block), penalty ? Word("-") : Word("+"),
                 penalty ? 1 : 2);
        if (c == clearances_.front())
          plot.add("title {}", formulation);
        else
          plot.add("notitle");
        if (penalty && std::isfinite(end))
          f.script.add("set label '{:.2f} mm' at {},{} left\n", 1e3 * c, speeds_.back() + 4, end);
      }
    // X7, X6, X8 times r ω² (1 + r/l) = 25.59 m/s² of the ideal mechanism at 200 rpm.
    f.script.add("{}, {}", plot,
                 measured(f, Block("measured").row({200, 89.6}).row({200, 102.4}).row({200, 511.8})));
    return draw(f, folder_);
  }

  std::filesystem::path surface() {
    auto f = begin("surface", 9);
    f.script.add(
        "unset bmargin\nset multiplot layout 1,2\nunset key\nset xlabel 'Clearance (mm)' offset 0,-0.5\nset ylabel 'Speed "
        "(rpm)' offset -1,-0.7\nset view 62,320,1,0.9\nset ticslevel "
        "0\nset ytics 100,50,250 offset -0.2,-0.6\nset xtics 0.25,0.25,1 offset 0,-0.2\n");
    double top = 0;
    for (const auto& [key, rows] : greatest_) top = std::max(top, rows[0][0]);
    f.script.add("set zrange [0:{}]\n", 1.1 * top);
    for (const auto& [family, formulation] : families) {
      Block block(
          "clearance (mm), speed (rpm), 95 % quantile over revolutions of the greatest acceleration (m/s^2)");
      for (double c : clearances_) {
        for (double n : speeds_) add_point(greatest_, {formulation, c, n}, {1e3 * c, n}, block);
        if (c != clearances_.back()) block.gap();
      }
      f.script.add("set title {}\nsplot {} using 1:2:3 with linespoints ls {}\n",
                   fmt::format("{}: greatest acceleration (m/s²)", formulation), data(f, block),
                   family == Family::penalty ? 1 : 2);
    }
    f.script.add("unset multiplot\n");
    return draw(f, folder_);
  }

  std::filesystem::path folder_;
  std::string variant_, paper_;
  Cells traces_, spectra_, peaks_, greatest_;
  std::vector<double> clearances_, speeds_;
};

std::vector<std::filesystem::path> draw_experiment(const std::filesystem::path& folder) {
  const auto variant = variant_to_draw(folder);
  if (variant.empty()) return {};
  return Experiment(folder, variant).all();
}

}  // namespace

std::string variant_to_draw(const std::filesystem::path& folder) {
  const Table table(folder / "cells.csv", {"variant"}, {});
  const auto& variants = table.text("variant");
  if (variants.empty()) return "";
  return std::ranges::find(variants, "calibrated") != variants.end() ? "calibrated" : variants.front();
}

std::vector<std::filesystem::path> draw_matrix_of_paper(const std::filesystem::path& folder,
                                                        const std::string& variant,
                                                        const std::string& source) {
  return Experiment(folder, variant, source).numbered();
}

const Drawing experiment{{"experiment.json"}, draw_experiment};

}  // namespace freeplay::plots
