// Attractor: classification of the limit set of a motion from its section points. The period is the
// least n ≤ most for which each kept point recurs n points later,
//
//     max_i max_j |x_j(i + n) − x_j(i)| / s_j ≤ tolerance,        i = 1 … m − n,   m ≥ 3n.
//
// Without such an n the motion is aperiodic (chaotic, quasi-periodic, of long period, or a
// transient that has not decayed). Without points nothing is known (a ball at rest has no contact
// onsets). The scale s_j of a column is its greatest magnitude; of an angle π, of a phase ½. Angles
// and phases are compared on their circle.
//
// A cycle is represented by its limit under the assumption of geometric convergence (Aitken's Δ²
// from the first, middle and last cycle). If the limit recurs sooner, as for points that alternate
// about an orbit with decreasing amplitude, its period is used.
//
// Two orbits of one period are equal if the points of a cycle agree, from some phase on, within
// three tolerances. All aperiodic motions of one section count as one attractor.
#pragma once

#include <span>
#include <string>
#include <vector>

namespace freeplay {

/// Parameters of the comparison of points.
struct Likeness {
  std::vector<double> circles;  ///< for each column the length of its circle, 0 for none
  double tolerance = 1e-3;
  int most = 16;  ///< greatest period considered
};

/// The limit set of a motion.
struct Attractor {
  static constexpr int none = -1, aperiodic = 0;
  int period = none;
  std::vector<double> points;  ///< one cycle in its limit, or the last point; rows of the columns
  std::vector<double> scale;   ///< of each column
  /// Text: "period 2", "aperiodic" or "no points".
  std::string name() const;
};

/// Classifies section points. `rows`: as many columns as likeness.circles.
Attractor attractor_of(std::span<const double> rows, const Likeness& likeness);

/// Whether two attractors are equal, as defined above.
bool same(const Attractor& a, const Attractor& b, const Likeness& likeness);

/// Index of an attractor in a list; a new one is appended.
std::size_t place_among(std::vector<Attractor>& list, const Attractor& one, const Likeness& likeness);

}  // namespace freeplay
