// Where a function watched during a step first leaves its sign: on the dense output of the step, by samples,
// and between samples of one sign at the turning point.
#pragma once

#include <algorithm>
#include <boost/math/tools/toms748_solve.hpp>
#include <cmath>
#include <optional>

#include "model/planar.hpp"
#include "model/system.hpp"

namespace freeplay {

/// A function's value and its rate of change.
struct Watched {
  double value = 0, rate = 0;
};

/// Bodies that turn bring their contacts round: a step (s) may not turn any so far that one could come and go
/// unseen between the samples of its gap. `v`: velocities of the bodies.
inline double longest_step(const System& system, const double* v) {
  double omega = 0;
  if (system.contacts() == 0) return INFINITY;
  for (int b = 0; b < system.bodies(); ++b) omega = std::max(omega, std::abs(planar::rate(v, b)));
  return omega > 0 ? 0.3 / omega : INFINITY;
}

/// Of f between a and b, where it has the opposite signs fa and fb; b where rounding leaves nothing between.
template <class F>
double bracketed_root(F f, double a, double b, double fa, double fb) {
  if (!(a < b)) return b;
  std::uintmax_t most = 100;
  const auto [lo, hi] =
      boost::math::tools::toms748_solve(f, a, b, fa, fb, boost::math::tools::eps_tolerance<double>(50), most);
  return 0.5 * (lo + hi);
}

/// First time in [t0, t1] at which `at`, positive while a mode lasts, becomes negative: t0 when it never was
/// positive. `start` and `end` are its values at the ends. A start below `noise` that rises counts as zero.
template <class F>
std::optional<double> first_loss(F at, double t0, double t1, Watched start, Watched end, double noise = 0) {
  constexpr int samples = 4;
  const double h = t1 - t0;
  // Far from zero for as fast as it moves: nothing to look for.
  if (std::min(start.value, end.value) > 2 * h * std::max(std::abs(start.rate), std::abs(end.rate)))
    return std::nullopt;
  if (start.value <= noise && start.rate > 0) start.value = 0;  // just changed mode here: rounding
  const auto value = [&](double t) { return at(t).value; };
  const auto rate = [&](double t) { return at(t).rate; };
  double ta = t0;
  Watched a = start;
  for (int s = 1; s <= samples; ++s) {
    const double tb = s == samples ? t1 : t0 + h * s / samples;
    const Watched b = s == samples ? end : at(tb);
    if (b.value >= 0 && a.rate < 0 && b.rate > 0 &&
        std::min(a.value, b.value) < (tb - ta) * std::max(-a.rate, b.rate)) {
      const double turn = bracketed_root(rate, ta, tb, a.rate, b.rate), least = value(turn);
      if (least < 0 && a.value > 0) return bracketed_root(value, ta, turn, a.value, least);
    }
    if (b.value < 0) {
      if (a.value > 0) return bracketed_root(value, ta, tb, a.value, b.value);
      // It may have left zero upwards, and come back within one sample, however early.
      double back = tb, below = b.value;
      for (int halves = 0; halves < 50; ++halves) {
        const double up = ta + 0.5 * (back - ta), above = value(up);
        if (above > 0) return bracketed_root(value, up, back, above, below);
        back = up;
        below = above;
      }
      return t0;  // never left zero: the mode ends where it began
    }
    ta = tb;
    a = b;
  }
  return std::nullopt;
}

/// What the gap of contact k is known to by rounding of the positions (m).
inline double gap_rounding(const System& system, int k) {
  return 1e-13 * system.contact_facts(k).clearance + 4e-16 * system.longest_arm();
}

/// Ends the last step of `method` at t; where that is its beginning, it begins anew there.
template <class Method, class F>
void land_at(Method& method, F& f, double t) {
  if (t <= method.t_old)
    method.start(f, method.t_old, method.x_old);
  else
    method.land(f, t);
}

/// The same where a gap comes to zero: t is corrected by Newton on `gap` (Watched) at the end of the step, down to
/// `rounding`.
template <class Method, class F, class Gap>
void land_on_gap(Method& method, F& f, double& t, double rounding, Gap gap) {
  if (t <= method.t_old) return land_at(method, f, t);
  for (int i = 0; i < 5; ++i) {
    method.land(f, t);
    const Watched end = gap();
    if (std::abs(end.value) <= rounding || end.rate == 0) return;
    const double next = t - end.value / end.rate;
    if (!(next > method.t_old) || std::abs(next - t) <= 2e-16 * t) return;
    if (std::abs(next - t) > 0.1 * (t - method.t_old)) return;  // grazing: keep the bracketed root
    t = next;
  }
}

/// Ends the last step of `method` at `first` by land(first); then, while the shorter step, sampled more
/// closely, shows a gap that was lost before, at that. gaps() gives the first loss of a gap in the step as it
/// is, or an event at its end.
template <class Method, class Event, class Land, class Gaps>
void land_on_first(const Method& method, Event& first, Land land, Gaps gaps) {
  land(first);
  for (int tries = 0; tries < 20; ++tries) {
    const Event before = gaps(first);
    const double edge = 1e-6 * (method.t - method.t_old);
    if (!(before.t > method.t_old + edge && before.t < method.t - edge)) return;
    land(first = before);
  }
}

}  // namespace freeplay
