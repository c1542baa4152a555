// The tables [bifurcation] and [basin] of a study. docs/reference/study.md lists their keys.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace freeplay {

class Section;
struct Axis;

/// Common parameters: how a run is made, and how attractors are distinguished.
struct AttractorPlan {
  std::string formulation = "nonsmooth";
  std::vector<std::string> overrides;  ///< keys of the scene, KEY=VALUE
  std::string section = "every period";
  std::optional<double> period;     ///< s, instead of the drive's period
  double discard = 200, keep = 60;  ///< periods
  /// Columns that distinguish attractors; empty: the default ones of the section.
  std::vector<std::string> columns;
  double tolerance = 1e-3;
  int most_period = 16;
  bool exponents = false;  ///< whether the largest Lyapunov exponents are computed
  /// Periods over which they are averaged, at least; without it `keep`.
  std::optional<double> exponent_periods;
  double averaged() const { return exponent_periods.value_or(keep); }
};

/// Parameters of a bifurcation diagram.
struct BifurcationPlan : AttractorPlan {
  std::size_t axis = 0;         ///< index in the axes of the study
  bool up = true, down = true;  ///< each value starts where its neighbour ended
  int starts = 0;               ///< number of additional drawn starts of each value
};

/// Parameters of basins of attraction.
struct BasinPlan : AttractorPlan {
  std::size_t x = 0, y = 1;  ///< indices in the axes of the study
};

/// Readers of the two tables. `axes`: those of the study. Throw SceneError.
BifurcationPlan read_bifurcation(Section s, const std::vector<Axis>& axes);
BasinPlan read_basin(Section s, const std::vector<Axis>& axes);

}  // namespace freeplay
