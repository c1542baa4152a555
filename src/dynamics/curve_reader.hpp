// A curve y(x) of an element as the choice of steps sees it: its argument x and the rate of x. Let
// n be the degree of the stretch that contains x, L its length and λ the period of its sine. The
// length over which y varies is
//
//     λ of a sine,     L for n ≥ 4,     4 L for n = 2, 3,     ∞ for a straight line
//
// A step of a given share of that length resolves the curve
// (formulations/integrators/curve_limit.hpp).
#pragma once

#include <string>
#include <utility>

#include "dynamics/phase.hpp"
#include "mechanism/piecewise.hpp"

namespace freeplay {

struct CurveReader {
  enum class Of { time, place, speed };
  std::string name;  ///< of the element
  Of of = Of::time;
  /// Angle or travel, whose rate is the speed; its kinks are the knots of the curve.
  Phase place = {};
  Piecewise course = {};

  /// x and its rate. If x is a speed, its rate is unknown here and given as 0.
  Watched argument(double t, const double* q, const double* v) const {
    if (of == Of::time) return {t, 1};
    const auto now = place.place_at(q, v);
    return of == Of::place ? now : Watched{now.rate, 0};
  }
  /// The length over which y varies at x; at a knot, that of the stretch above or below.
  double variation(double x, bool above) const {
    const double rounding = 1e-12 * std::fmax(1, std::abs(x));
    return course.variation(above ? x + rounding : x - rounding);
  }
};

}  // namespace freeplay
