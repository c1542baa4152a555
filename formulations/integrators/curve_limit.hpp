// Limits of the step length, so that no step passes over a feature of a curve that it reads: a
// curve against time, an angle, a position or a speed, of a prescribed motion, a force or a torque.
// An error estimate evaluates a curve only at the stages of a step, and does not detect deviations
// of a prescribed motion between the ends of the step. With the argument x, its rate ẋ at the
// beginning, the length L over which y(x) varies on the present stretch
// (dynamics/phase.hpp), and the rest r of the stretch, a step of length h satisfies
//
//     |ẋ| h ≤ L/16        and, where knots are not located,        |ẋ| h ≤ L/32,  r + w/10000,  w/2
//
// where w is the length of the stretch; in w/10000 it is the lesser of this length and the next
// one, because a rate that grows beyond the knot affects the rows of the whole step before it. If ẋ
// grows within the step (a body at rest, a speed), this is no bound: curve_overreach() checks the
// step at its end, and the step is repeated with a shorter length if it went too far: by half of
// the limit, or beyond a knot of a speed by more than w/100.
//
// Every scheme locates knots in time (System::next_knot()). Integrators with Phases
// (integrators/kinks.hpp) locate knots of angles, positions and speeds.
#pragma once

#include <algorithm>
#include <cmath>

#include "dynamics/system.hpp"

namespace freeplay {

/// Whether a scheme ends its steps at the knots of curves against angles, positions and speeds, or
/// only avoids passing over them.
enum class Knots { located, passed };

namespace curve_limits {

/// A knot ahead: the way to it and the lesser length of the stretches on both sides of it.
struct Ahead {
  double rest = INFINITY, width = INFINITY, least = INFINITY;
};
inline Ahead knot_ahead(const CurveReader& reader, double x, bool up) {
  if (reader.place.kinks.empty() || reader.of == CurveReader::Of::time) return {};
  const auto piece = reader.place.piece(x, up), next = reader.place.piece(up ? piece.high : piece.low, up);
  const double rest = up ? piece.high - x : x - piece.low, width = piece.high - piece.low,
               least = std::min(width, next.high - next.low);
  return {rest, width, std::isfinite(least) ? least : rest};
}

/// The greatest change of the argument of `reader` from x in one step, upwards or downwards.
inline double reach(const CurveReader& reader, double x, bool up, Knots knots) {
  // With a sixteenth, the error of Dormand and Prince's dense output is below 1e-6 of a sine's
  // amplitude, or of a rise. Schemes that pass knots are of second order: with a thirty-second, the
  // difference of speeds between a step and its halves is 0.2 %.
  const double most = reader.variation(x, up) / (knots == Knots::passed ? 32 : 16);
  if (knots == Knots::located) return most;
  const auto [rest, width, least] = knot_ahead(reader, x, up);
  return std::min({most, std::isfinite(rest) ? rest + 1e-4 * least : rest, 0.5 * width});
}

}  // namespace curve_limits

/// s: greatest length of a step from (t, q, v); infinite without curves.
inline double curve_step_limit(const System& system, double t, const double* q, const double* v,
                               Knots knots) {
  double limit = INFINITY;
  for (const auto& reader : system.curves().readers) {
    const auto x = reader.argument(t, q, v);
    if (x.rate == 0) continue;
    limit = std::min(limit, curve_limits::reach(reader, x.value, x.rate > 0, knots) / std::abs(x.rate));
  }
  return limit;
}

/// Checks a step from (t0, q0, v0) to (t1, q1, v1): 0 if it is short enough, or the factor, above
/// 1, by which a step that does not go too far is shorter.
inline double curve_overreach(const System& system, double t0, const double* q0, const double* v0, double t1,
                              const double* q1, const double* v1, Knots knots) {
  constexpr double most_overreach = 1.5;
  double worst = 0;
  for (const auto& reader : system.curves().readers) {
    if (reader.of == CurveReader::Of::time) continue;  // by curve_step_limit()
    const auto from = reader.argument(t0, q0, v0), to = reader.argument(t1, q1, v1);
    const double way = to.value - from.value,
                 path = std::max(std::abs(way), 0.5 * (t1 - t0) * (std::abs(from.rate) + std::abs(to.rate)));
    if (!(path > 1e-12 * std::abs(from.value))) continue;
    const double over = path / curve_limits::reach(reader, from.value, way > 0, knots);
    bool too_far = over > most_overreach;
    if (knots == Knots::passed && reader.of == CurveReader::Of::speed) {
      const auto knot = curve_limits::knot_ahead(reader, from.value, way > 0);
      too_far = too_far || path > knot.rest + 1e-2 * knot.least;
    }
    if (too_far) worst = std::max(worst, over);
  }
  return worst;
}

}  // namespace freeplay
