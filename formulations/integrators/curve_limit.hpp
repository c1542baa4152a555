// How long a step may be so that no curve that it reads is jumped over: a curve against time, an angle, a position or a
// speed, of a prescribed motion, a force or a torque. An error estimate sees a curve only where its stages fall, and nothing of
// a prescribed motion that the step's ends meet. With x the argument, ẋ its rate at the beginning, L the length that y(x)
// varies over on the present stretch (dynamics/curve_reader.hpp), and r what is left of the stretch, a step of length h has
//
//     |ẋ| h ≤ L/16        and, where knots are not located,        |ẋ| h ≤ L/32,  r + w/10000,  w/2
//
// with w the length of the stretch, in w/10000 the lesser of it and the next one: a rate that grows behind the knot bends the
// rows of the whole step before it. Where ẋ grows within the step (a body at rest, a speed), that is no bound: the step is
// looked at once more at its end, by curve_overreach(), and made again, shorter, where it went further than it may.
//
// Knots in time are located by every scheme (System::next_knot()); those of angles and positions by integrators that have
// Phases (integrators/phases.hpp); those of speeds by none.
#pragma once

#include <algorithm>
#include <cmath>

#include "dynamics/system.hpp"

namespace freeplay {

/// Whether a scheme ends its steps at the knots of curves against angles and positions, or only does not jump over them.
enum class Knots { located, passed };

namespace curve_limits {

/// How far (in units of its argument) `reader` may go from x, upwards or downwards.
inline double reach(const CurveReader& reader, double x, bool up, Knots knots) {
  // A sixteenth leaves Dormand and Prince's dense output off by less than 1e-6 of a sine's amplitude, or of a rise. Schemes that
  // pass knots are of second order: a thirty-second leaves the speed between a step and its half off by 0.2 %.
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

/// s: how long a step from (t, q, v) may be; infinite without curves.
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

/// How far an argument went in a step from (t0, q0, v0) to (t1, q1, v1), over what it may; 0 without curves. Where that is more
/// than most_overreach, the step is to be made again, by that factor shorter.
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
