// The runs of a sweep for figures: sweep.db, with names, units and scales from sweep.json.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "plots/tables/columns.hpp"
#include "study/store/results.hpp"

namespace freeplay::plots {

/// An axis of the sweep.
struct SweepAxis {
  std::string name, unit;
  double scale = 1;    ///< displayed value = value · scale
  bool drawn = false;  ///< random values instead of a list
};

/// A number of each run that can be drawn.
struct SweepQuantity {
  enum class Of { statistic, measure, derived };
  std::string name, unit;
  Of of = Of::statistic;
  std::size_t place = 0;    ///< in RunRow::metric, or in RunRow::measures
  std::string column = {};  ///< the number of run.json that a measure shows as it is; else empty
};

/// One cell of the study: runs that differ in their start only.
struct SweepCell {
  std::string variant, formulation;
  std::vector<double> values;  ///< of the axes, unscaled
};

class SweepRuns {
 public:
  /// Reads the finished runs that the study names. Throws SceneError if the folder has no sweep, no
  /// sweep.json or no finished run.
  explicit SweepRuns(const std::filesystem::path& folder);

  const std::vector<SweepAxis>& axes() const { return axes_; }
  /// All cells with a finished run, ordered by variant, formulation and axes.
  const std::vector<SweepCell>& cells() const { return cells_; }
  /// The quantity of this name. Throws SceneError, which lists those that have values, if there is
  /// none.
  const SweepQuantity& quantity(const std::string& name) const;
  /// The place of the axis of this name. Throws SceneError, which lists the axes, if there is none.
  std::size_t axis(const std::string& name) const;
  /// Mean over the starts of a cell with its 95 % interval, as the table of `sweep` shows it.
  Interval at(const SweepCell& cell, const SweepQuantity& quantity) const;

 private:
  std::string unknown(const std::string& name) const;

  std::vector<SweepAxis> axes_;
  std::vector<SweepQuantity> quantities_;
  std::vector<RunRow> rows_;  // `measures` also contains the derived quantities
  std::vector<SweepCell> cells_;
};

/// "name (unit)", or the name without a unit.
std::string name_with_unit(const std::string& name, const std::string& unit);

/// "unknown WHAT name", with the most similar name, and the list of all names.
std::string unknown_name(const char* what, const std::string& name, const NamesByKind& lists);

}  // namespace freeplay::plots
