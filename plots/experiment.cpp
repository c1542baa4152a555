// The figures of a study of the test matrix (axes clearance and speed): what figures 5 to 13 of Flores et al.
// 2011 show, from the model, penalty beside nonsmooth, with the measured values that the paper's text states.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "plots/figure.hpp"
#include "values/family.hpp"

namespace freeplay::plots {
namespace {

struct Key {
  std::string formulation;
  double clearance, speed;
  auto operator<=>(const Key&) const = default;
};

/// Rows of one variant of a table, by formulation and cell: the chosen columns as gnuplot lines.
using Table = std::map<Key, std::string>;

constexpr const char* angles = "set xrange [0:360]\nset xtics 90\n";

class Experiment {
 public:
  Experiment(const std::filesystem::path& folder, const std::string& variant)
      : folder_(folder), variant_(variant) {
    traces_ = read("traces.csv", {"angle", "acceleration", "position"}, "");
    spectra_ = read("spectra.csv", {"harmonic", "amplitude"}, "");
    peaks_ = read("cells.csv", {"mean", "low", "high"}, "ratio_95");
    greatest_ = read("cells.csv", {"mean", "low", "high"}, "peak_95");
    for (const auto& [key, rows] : peaks_) {
      if (std::ranges::find(clearances_, key.clearance) == clearances_.end())
        clearances_.push_back(key.clearance);
      if (std::ranges::find(speeds_, key.speed) == speeds_.end()) speeds_.push_back(key.speed);
    }
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

 private:
  Table read(const std::string& file, const std::vector<std::string>& columns,
             const std::string& statistic) const {
    const Csv csv(folder_ / file);
    const auto &variants = csv.text("variant"), &formulations = csv.text("formulation");
    const auto clearance = csv.column("clearance"), speed = csv.column("speed");
    Table table;
    for (std::size_t i = 0; i < csv.rows(); ++i) {
      if (variants[i] != variant_ || (!statistic.empty() && csv.text("statistic")[i] != statistic)) continue;
      auto& block = table[{formulations[i], clearance[i], speed[i]}];
      for (const auto& c : columns) block += csv.text(c)[i] + " ";
      block += "\n";
    }
    return table;
  }
  Figure begin(const std::string& what, double height) const {
    Figure f;
    f.name = "experiment_" + what;
    f.source = "experiment.json";
    f.height_cm = height;
    return f;
  }
  /// Adds a block; the beginning of its plot command.
  static std::string data(Figure& f, const std::string& block) {
    f.blocks.push_back(block);
    return fmt::format("'DATA' index {}", f.blocks.size() - 1);
  }
  static double nearest(const std::vector<double>& list, double x) {
    return *std::ranges::min_element(list, {}, [x](double v) { return std::abs(v - x); });
  }
  double paper_speed() const { return nearest(speeds_, 200); }
  double paper_clearance() const { return nearest(clearances_, 0.25e-3); }

  /// Curves of one cell: both formulations over the ideal.
  static std::string curves(Figure& f, const Table& table, double c, double n, const std::string& use,
                            bool titles) {
    std::string plot;
    const std::pair<const char*, int> styles[] = {{"ideal", 3}, {"penalty", 1}, {"nonsmooth", 2}};
    for (const auto& [formulation, line] : styles) {
      const auto it = table.find({formulation, c, n});
      if (it == table.end()) continue;
      plot +=
          fmt::format("{}{} using {} with lines ls {} {}", plot.empty() ? "plot " : ", ", data(f, it->second),
                      use, line, titles ? fmt::format("title '{}'", formulation) : "notitle");
    }
    return plot + "\n";
  }

  std::filesystem::path motion() {
    auto f = begin("motion", 12);
    const double c = paper_clearance(), n = paper_speed();
    f.script = fmt::format(
        "set multiplot layout 2,1 margins 0.11,0.97,0.12,0.9 spacing 0.02,0.06\n{}set key at screen "
        "0.97,0.985 horizontal\nset format x ''\nset ylabel 'Position (m)'\nset label 1 '{:.2f} mm, {:.0f} "
        "rpm' at screen 0.11,0.96\n",
        angles, 1e3 * c, n);
    f.script += curves(f, traces_, c, n, "1:3", true);
    f.script +=
        "unset key\nunset label 1\nset format x\nset xlabel 'Crank angle (°)'\nset ylabel 'Acceleration "
        "(m/s²)'\n";
    f.script += curves(f, traces_, c, n, "1:2", false) + "unset multiplot\n";
    return draw(f, folder_);
  }

  std::filesystem::path panels(const std::string& what, bool along_clearance, bool spectrum) {
    auto f = begin(what, 13);
    f.script = "set multiplot layout 2,2 margins 0.1,0.98,0.11,0.9 spacing 0.1,0.13\n";
    f.script += spectrum ? "set logscale y\nset format y '%g'\nset xlabel 'Harmonic of the crank' offset "
                           "0,0.5\nset xrange [0:100]\n"
                         : std::string(angles) + "set xlabel 'Crank angle (°)' offset 0,0.5\n";
    const auto& values = along_clearance ? clearances_ : speeds_;
    for (std::size_t i = 0; i < std::min<std::size_t>(values.size(), 4); ++i) {
      const double c = along_clearance ? values[i] : paper_clearance(),
                   n = along_clearance ? paper_speed() : values[i];
      f.script += fmt::format("set title '{:.2f} mm, {:.0f} rpm' offset 0,-0.8\n", 1e3 * c, n);
      f.script += i % 2 == 0
                      ? fmt::format("set ylabel '{} (m/s²)'\n", spectrum ? "Amplitude" : "Acceleration")
                      : std::string("unset ylabel\n");
      f.script += i == 0 ? "set key at screen 0.98,0.985 horizontal\n" : "unset key\n";
      f.script += curves(f, spectrum ? spectra_ : traces_, c, n, "1:2", i == 0);
    }
    f.script += "unset multiplot\n";
    return draw(f, folder_);
  }

  std::filesystem::path velocities() {
    auto f = begin("velocity", 12);
    f.script = fmt::format(
        "set multiplot layout 2,1 margins 0.11,0.97,0.12,0.9 spacing 0.02,0.08\n{}set format x ''\nset "
        "ylabel 'Velocity (m/s)'\n",
        angles);
    const double n = paper_speed();
    // Of the position's signal, by differences between samples; the first of a curve has none.
    const std::string rate = fmt::format(
        "1:(d = $3 - x0, s = ($1 - a0)/360*{}, x0 = $3, a0 = $1, (s > 0 && s < 0.01) ? d/s : 1/0)", 60 / n);
    const auto last = clearances_.size();
    for (std::size_t i = last >= 2 ? last - 2 : 0; i < last; ++i) {
      f.script += fmt::format("x0 = 0; a0 = 1e9\nset title '{:.2f} mm, {:.0f} rpm' offset 0,-0.8\n",
                              1e3 * clearances_[i], n);
      f.script += i + 1 == last ? "set format x\nset xlabel 'Crank angle (°)'\nunset key\n"
                                : "set key at screen 0.98,0.985 horizontal\n";
      f.script += curves(f, traces_, clearances_[i], n, rate, i + 1 != last);
    }
    f.script += "unset multiplot\n";
    return draw(f, folder_);
  }

  /// How the measured points are drawn, and whether they may surprise.
  std::string measured() const {
    return fmt::format(" using 1:2 with points pt 7 ps 1.4 lc rgb '#000000' title 'measured{}'\n",
                       variant_ == "calibrated" ? ", and fitted to" : "");
  }

  std::filesystem::path peaks_by_clearance() {
    auto f = begin("peaks_clearance", 9);
    f.script =
        "set logscale y\nset ylabel 'Greatest acceleration over the ideal'\nset xlabel 'Clearance (mm)'\nset "
        "xrange [0:1.1]\n"
        "set yrange [1:100]\nset key outside top center horizontal\nplot ";
    for (const auto& [family, formulation] : families) {
      std::string block = "# clearance, mean, low, high\n";
      const bool penalty = family == Family::penalty;
      for (double c : clearances_)
        if (const auto it = peaks_.find({formulation, c, paper_speed()}); it != peaks_.end())
          block += fmt::format("{} {}", 1e3 * c, it->second);
      // Moved apart to be seen, in the figure alone.
      f.script += fmt::format("{} using ($1{}0.004):2:3:4 with yerrorlines ls {} title '{}', ",
                              data(f, block), penalty ? '-' : '+', penalty ? 1 : 2, formulation);
    }
    f.script += data(f, "# measured: X7, X6, X8\n0.10 3.5\n0.25 4\n1.00 20\n") + measured();
    return draw(f, folder_);
  }

  std::filesystem::path peaks_by_speed() {
    auto f = begin("peaks_speed", 9);
    std::string plot;
    f.script =
        "set logscale y\nset ylabel 'Greatest acceleration (m/s²)'\nset xlabel 'Crank speed (rpm)'\nset "
        "xrange [90:280]\nset key "
        "outside top center horizontal\n";
    for (double c : clearances_)
      for (const auto& [family, formulation] : families) {
        const bool penalty = family == Family::penalty;
        std::string block = "# speed, mean, low, high\n", end;
        for (double n : speeds_)
          if (const auto it = greatest_.find({formulation, c, n}); it != greatest_.end()) {
            block += fmt::format("{} {}", n, it->second);
            end = it->second.substr(0, it->second.find(' '));
          }
        plot +=
            fmt::format("{}{} using ($1{}1):2:3:4 with yerrorlines ls {} {}", plot.empty() ? "plot " : ", ",
                        data(f, block), penalty ? '-' : '+', penalty ? 1 : 2,
                        c == clearances_.front() ? fmt::format("title '{}'", formulation) : "notitle");
        if (penalty && !end.empty())
          f.script += fmt::format("set label '{:.2f} mm' at {},{} left\n", 1e3 * c, speeds_.back() + 4, end);
      }
    // X7, X6, X8 times the ideal's r ω² (1 + r/l) = 25.59 m/s² at 200 rpm.
    f.script += plot + ", " + data(f, "200 89.6\n200 102.4\n200 511.8\n") + measured();
    return draw(f, folder_);
  }

  std::filesystem::path surface() {
    auto f = begin("surface", 9);
    f.script =
        "set multiplot layout 1,2\nunset key\nset xlabel 'Clearance (mm)' offset 0,-0.5\nset ylabel 'Speed "
        "(rpm)' offset 0,-0.5\nset zlabel 'm/s²' rotate offset 1,0\nset view 62,320,1,0.9\nset ticslevel "
        "0\nset ytics 100,50,200 offset 0,-0.2\nset xtics 0.25,0.25,1 offset 0,-0.2\n";
    double top = 0;
    for (const auto& [key, row] : greatest_) top = std::max(top, std::strtod(row.c_str(), nullptr));
    f.script += fmt::format("set zrange [0:{}]\n", 1.1 * top);
    for (const auto& [family, formulation] : families) {
      std::string block =
          "# clearance (mm), speed (rpm), 95 % quantile over turns of the greatest acceleration (m/s^2)\n";
      for (double c : clearances_) {
        for (double n : speeds_)
          if (const auto it = greatest_.find({formulation, c, n}); it != greatest_.end())
            block += fmt::format("{} {} {}", 1e3 * c, n, it->second);
        if (c != clearances_.back()) block += "\n";
      }
      f.script += fmt::format("set title '{}'\nsplot {} using 1:2:3 with linespoints ls {}\n", formulation,
                              data(f, block), family == Family::penalty ? 1 : 2);
    }
    f.script += "unset multiplot\n";
    return draw(f, folder_);
  }

  std::filesystem::path folder_;
  std::string variant_;
  Table traces_, spectra_, peaks_, greatest_;
  std::vector<double> clearances_, speeds_;
};

std::vector<std::filesystem::path> draw_all(const std::filesystem::path& folder) {
  const auto variants = Csv(folder / "cells.csv").text("variant");
  const bool calibrated = std::ranges::find(variants, "calibrated") != variants.end();
  return Experiment(folder, calibrated ? "calibrated" : variants.front()).all();
}

}  // namespace

const Drawing experiment{{"experiment.json"}, draw_all};

}  // namespace freeplay::plots
