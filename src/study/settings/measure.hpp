// A measure: one column of a run's tables, reduced to a number over the window that counts (from the discarded time to the end),
//
//     mean, rms, std   over time, by the trapezoidal rule between rows: (1/T)∫x dt, √((1/T)∫x² dt), √((1/T)∫(x − mean)² dt)
//     min, max, peak   of the rows and the ends of all steps; peak is the greatest |x|
//     quantile         of the rows, linear between them in the order of size
//     first, last, count   of the rows
//
// over the whole window, or over each whole period of it (then the number is the mean of the periods' numbers), or over the
// points of a section alone (simulation/section.hpp; then every point counts alike). Rows are those of trajectory.csv within the window,
// with one more at its beginning and at each period's; of signals every sample, each counting alike.
#pragma once

#include <optional>
#include <string>

#include "mechanism/keys.hpp"

namespace freeplay {

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

struct Measure {
  std::string name;
  std::string
      column;  ///< as the header of trajectory.csv or forces.csv has it, an instrument, or a path in run.json
  Reduce reduce = Reduce::mean;
  double q = 0.5;  ///< of the quantile
  bool each_period = false;
  std::string at;  ///< section; empty: none
};

class Section;

/// Reads [measure.NAME].
Measure read_measure(const std::string& name, Section& section);
/// A line that says all of it, for identities.
std::string said(const Measure& measure);

}  // namespace freeplay
