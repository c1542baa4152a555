// What a motion has settled to, as its section points tell it: the least n ≤ most for which every kept point is met again
// n points later,
//
//     max_i max_j |x_j(i + n) − x_j(i)| / s_j ≤ tolerance,        i = 1 … m − n,   m ≥ 3n,
//
// is its period; without such an n it is aperiodic (chaos, a torus, a long period, or a transient that has not died), and
// without any point there is nothing to tell (a ball that rests has no touches). The scale s_j of a column is its greatest
// magnitude, of an angle π, of a phase ½; angles and phases are compared on their circle.
//
// A cycle stands for where its points go on to if their steps shrink by one factor (Aitken's Δ² over the first, the middle and
// the last cycle). Where these repeat sooner, as of what alternates about an orbit by ever less, their period is taken.
//
// Two orbits of one period are the same where the points of one cycle agree, from some point on, to three tolerances; all
// aperiodic motions of one section are taken for one.
#pragma once

#include <span>
#include <string>
#include <vector>

namespace freeplay {

/// How points are compared.
struct Likeness {
  std::vector<double> circles;  ///< of each column the length of its circle, 0 for none
  double tolerance = 1e-3;
  int most = 16;  ///< the longest period looked for
};

struct Attractor {
  static constexpr int none = -1, aperiodic = 0;
  int period = none;
  std::vector<double> points;  ///< one cycle in its limit, or the last point; rows of the columns
  std::vector<double> scale;   ///< of each column
  /// "period 2", "aperiodic", "no points".
  std::string name() const;
};

/// `rows`: of as many columns as likeness has circles.
Attractor attractor_of(std::span<const double> rows, const Likeness& likeness);

bool same(const Attractor& a, const Attractor& b, const Likeness& likeness);

/// The place of an attractor in a list, to which it is added where it is new.
std::size_t place_among(std::vector<Attractor>& list, const Attractor& one, const Likeness& likeness);

}  // namespace freeplay
