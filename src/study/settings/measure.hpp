// Measure: one column of a run's result tables, reduced to a number over the window from the
// discarded time to the end, by
//
//     mean, rms, std   over time, by the trapezoidal rule between rows:
//                      (1/T)∫x dt, √((1/T)∫x² dt), √((1/T)∫(x − mean)² dt)
//     min, max, peak   of the rows and the ends of all steps; peak is the greatest |x|
//     quantile         of the rows, linear between sorted values
//     first, last, count   of the rows
//
// The reduction is taken over the whole window; or over each whole period in it, then averaged over
// the periods; or over the points of a Poincaré section (simulation/section.hpp), all with equal
// weight. Rows are those of trajectory.csv in the window, with an additional row at its beginning
// and at the beginning of each period. For signals, rows are the samples, with equal weight.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "mechanism/keys.hpp"
#include "study/settings/setting_values.hpp"

namespace freeplay {

/// Reductions of a column to a number, as defined above.
enum class Reduce { mean, rms, min, max, peak, first, last, std, quantile, count };
inline constexpr auto reduce_names = complete<Reduce>({{Reduce::mean, "mean"},
                                                       {Reduce::rms, "rms"},
                                                       {Reduce::min, "min"},
                                                       {Reduce::max, "max"},
                                                       {Reduce::peak, "peak"},
                                                       {Reduce::first, "first"},
                                                       {Reduce::last, "last"},
                                                       {Reduce::std, "std"},
                                                       {Reduce::quantile, "quantile"},
                                                       {Reduce::count, "count"}});

constexpr const auto& choices(Reduce) { return reduce_names; }

/// A measure as the study states it. It is evaluated by study/runs/measurer.hpp.
struct Measure {
  std::string name;
  /// A column of trajectory.csv or forces.csv, an instrument, or a path in run.json.
  std::string column;
  Reduce reduce = Reduce::mean;
  double q = 0.5;  ///< probability of the quantile
  bool each_period = false;
  std::string at;  ///< text of the section; empty: none
  /// @name Difference of the mean turn from that of a measured file (measure/waveform.hpp), instead
  /// of a reduced column
  ///@{
  std::filesystem::path waveform = {};
  std::string digest = {};                  ///< of the file
  double tolerance = 0;                     ///< relative uncertainty of the file
  std::vector<std::string> overrides = {};  ///< keys of the scene with which the file was measured
  ///@}

  static void keys(auto& k, auto& x) {
    k.need({"column", "", "column of trajectory.csv or forces.csv, an instrument, or a number of run.json"},
           x.column);
    k.need({"reduce", "", ""}, x.reduce);
    if (k.when(x.reduce == Reduce::quantile, {"q"}, "applies only to reduce = \"quantile\""))
      k.need({"q", "", "probability of the quantile, from 0 to 1"}, x.q, zero_to_one);
    k.other({"each", "", "\"period\": reduced over each period, then their mean"}, "text", x.each_period,
            [](auto& s, auto key) { return s.choice(key, {"period"}) == 0; });
    k.take({"at", "",
            "section: only its points are evaluated; \"every period\", \"JOINT.angle crosses VALUE "
            "upwards\", \"each touch\"",
            "–"},
           x.at);
    k.check(!x.each_period || x.at.empty(), "each",
            "and at both select parts of the window; give one of them");
  }
};

/// One line that states all of the measure, for identities.
std::string said(const Measure& measure);

}  // namespace freeplay
