// A curve that an element reads, as the choice of steps sees it: y(x), what x is and how fast it goes. With n the degree of
// the stretch that x lies on, L its length and λ the period of its sine, the length that y varies over is
//
//     λ of a sine,     L for n ≥ 4,     4 L for n = 2, 3,     ∞ for a straight line
//
// A step of a stated share of it resolves the curve (formulations/integrators/curve_limit.hpp).
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
  Phase place = {};  ///< angle or travel, whose rate is the speed; its kinks are the curve's knots
  Piecewise course = {};

  /// x and its rate; that of a speed is not known here: 0.
  Watched argument(double t, const double* q, const double* v) const {
    if (of == Of::time) return {t, 1};
    const auto now = place.at(q, v);
    return of == Of::place ? now : Watched{now.rate, 0};
  }
  /// The length that y varies over at x, on the stretch above or below where x is a knot.
  double variation(double x, bool above) const {
    const double rounding = 1e-12 * std::fmax(1, std::abs(x));
    return course.variation(above ? x + rounding : x - rounding);
  }
};

}  // namespace freeplay
