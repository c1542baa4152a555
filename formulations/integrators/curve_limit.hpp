// Limits of the step length, so that no step passes over a feature of a curve that it reads: a
// curve against time, an angle, a position or a speed, of a prescribed motion, a force or a torque.
// An error estimate evaluates a curve only at the stages of a step, and does not detect deviations
// of a prescribed motion between the ends of the step. With the argument x, its rate ẋ at the
// beginning, the length L over which y(x) varies on the present stretch
// (dynamics/curve_reader.hpp), and the rest r of the stretch, a step of length h satisfies
//
//     |ẋ| h ≤ L/16        and, where knots are not located,        |ẋ| h ≤ L/32,  r + w/10000,  w/2
//
// where w is the length of the stretch; in w/10000 it is the lesser of this length and the next
// one, because a rate that grows beyond the knot affects the rows of the whole step before it. If ẋ
// grows within the step (a body at rest, a speed), this is no bound: curve_overreach() checks the
// step at its end, and the step is repeated with a shorter length if it went too far.
//
// Every scheme locates knots in time (System::next_knot()). Integrators with Phases
// (integrators/phases.hpp) locate knots of angles and positions. Knots of speeds are not located.
#pragma once

#include <algorithm>
#include <cmath>

#include "dynamics/system.hpp"

namespace freeplay {

/// Whether a scheme ends its steps at the knots of curves against angles and positions, or only
/// avoids passing over them.
enum class Knots { located, passed };

namespace curve_limits {

/// The greatest change of the argument of `reader` from x in one step, upwards or downwards.
inline double reach(const CurveReader& reader, double x, bool up, Knots knots) {
  // With a sixteenth, the error of Dormand and Prince's dense output is below 1e-6 of a sine's
  // amplitude, or of a rise. Schemes that pass knots are of second order: with a thirty-second, the
  // difference of speeds between a step and its halves is 0.2 %.
  double most = reader.variation(x, up) / (knots == Knots::passed ? 32 : 16);
  const bool passed = knots == Knots::passed || reader.of == CurveReader::Of::speed;
  if (!passed || reader.place.kinks.empty() || reader.of == CurveReader::Of::time) return most;
  const auto piece = reader.place.piece(x, up), next = reader.place.piece(up ? piece.high : piece.low, up);
  const double rest = up ? piece.high - x : x - piece.low, width = piece.high - piece.low,
               least = std::min(width, next.high - next.low);
  if (std::isfinite(rest)) most = std::min(most, rest + 1e-4 * (std::isfinite(least) ? least : rest));
  return std::min(most, 0.5 * width);
}

}  // namespace curve_limits

/// s: greatest length of a step from (t, q, v); infinite without curves.
inline double curve_step_limit(const System& system, double t, const double* q, const double* v,
                               Knots knots) {
  double limit = INFINITY;
  for (const auto& reader : system.curve_readers()) {
    const auto x = reader.argument(t, q, v);
    if (x.rate == 0) continue;
    limit = std::min(limit, curve_limits::reach(reader, x.value, x.rate > 0, knots) / std::abs(x.rate));
  }
  return limit;
}

/// Change of an argument in a step from (t0, q0, v0) to (t1, q1, v1), over its limit; 0 without
/// curves. If it is more than most_overreach, the step is to be repeated, shorter by that factor.
inline constexpr double most_overreach = 1.5;
inline double curve_overreach(const System& system, double t0, const double* q0, const double* v0, double t1,
                              const double* q1, const double* v1, Knots knots) {
  double worst = 0;
  for (const auto& reader : system.curve_readers()) {
    if (reader.of == CurveReader::Of::time) continue;  // by curve_step_limit()
    const auto from = reader.argument(t0, q0, v0), to = reader.argument(t1, q1, v1);
    const double way = to.value - from.value,
                 path = std::max(std::abs(way), 0.5 * (t1 - t0) * (std::abs(from.rate) + std::abs(to.rate)));
    if (!(path > 1e-12 * std::abs(from.value))) continue;
    worst = std::max(worst, path / curve_limits::reach(reader, from.value, way > 0, knots));
  }
  return worst;
}

}  // namespace freeplay
