// Kinks of forces within a step: Phases and Limits.
//
// Phases: angles, distances and speeds at which tables and one-way forces have kinks. It keeps the
// present piece of each, and finds the first crossing of a kink in a step. A method that samples a
// table only at its stages may pass over whole pulses. Each table is therefore restricted to its
// present piece, on which it is smooth, and every kink is an event, located like a contact onset. A
// speed that approaches an equilibrium between two kinks crosses neither.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <vector>

#include "formulations/integrators/crossing.hpp"
#include "values/memory.hpp"

namespace freeplay {

class Phases {
 public:
  struct Crossing {
    int phase = -1;
    bool up = false;  ///< whether the upper end of the piece is reached, else the lower
    double t = 0;     ///< s
  };

  void start(const System& system, const double* q, const double* v) {
    pieces_.resize(static_cast<std::size_t>(system.phases()));
    for (std::size_t k = 0; k < pieces_.size(); ++k) {
      const auto& phase = system.phase(static_cast<int>(k));
      const auto now = phase.at(q, v);
      pieces_[k] = phase.piece(now.value, now.rate >= 0);
    }
  }
  bool any() const { return !pieces_.empty(); }

  /// The first crossing in a step from t0 to t1 from state x0 to x1 (q, v, ...) with these bounds,
  /// and before `before` (s). `at`: the state at a time within the step.
  template <class State, class At>
  Crossing first(const System& system, double t0, double t1, const State& x0, const State& x1,
                 const MotionBounds& bounds, double before, double& unseen, At at) const {
    Crossing found{-1, false, before};
    if (!(t1 > t0)) return found;
    for (int k = 0; k < static_cast<int>(pieces_.size()); ++k) {
      const auto& phase = system.phase(k);
      const auto& piece = pieces_[static_cast<std::size_t>(k)];
      StepCourse course;
      if (phase.speed) course = course_of(system, k, t0, t1, x0, x1, at);
      for (const bool up : {false, true}) {
        if (!std::isfinite(up ? piece.high : piece.low)) continue;
        const auto left = [&](const State& x, double t) {
          auto now = rest(system, k, up, x);
          if (phase.speed) now.rate = (up ? -1 : 1) * course.rate(t);
          return now;
        };
        const auto motion = phase.speed ? GapMotion{GapMotion::Shape::straight, 0, course.acceleration(), 0}
                                        : phase.motion(bounds, piece, up, x1.data());
        const double noise =
            phase.speed ? course_rounding * std::max(speed_of(phase), course.largest()) : rounding(k);
        const auto t = first_loss([&](double s) { return left(at(s), s); }, t0, t1, left(x0, t0),
                                  left(x1, t1), motion, noise, unseen);
        if (t && *t < found.t) found = {k, up, *t};
      }
    }
    return found;
  }
  /// Ends the last step of `method` at a crossing.
  template <class Method, class F>
  void land(const System& system, Method& method, F& f, Crossing& c) const {
    const auto& phase = system.phase(c.phase);
    if (phase.speed) return land_on_speed(system, method, f, c);
    land_on_gap(method, f, c.t, rounding(c.phase), [&] { return rest(system, c.phase, c.up, method.x); });
  }
  /// The pieces, for Reading::pieces.
  const Piece* pieces() const { return pieces_.data(); }
  /// Distance to the end of phase k's piece at a state, upwards or downwards, and its rate (rad,
  /// rad/s; 0 for a speed).
  template <class State>
  Watched rest(const System& system, int k, bool up, const State& x) const {
    const auto now = system.phase(k).at(x.data(), x.data() + system.n());
    const auto& piece = pieces_[static_cast<std::size_t>(k)];
    return up ? Watched{piece.high - now.value, -now.rate} : Watched{now.value - piece.low, now.rate};
  }
  double rounding(int k) const { return rounding(pieces_[static_cast<std::size_t>(k)]); }
  void cross(const System& system, const Crossing& c) {
    auto& piece = pieces_[static_cast<std::size_t>(c.phase)];
    piece = system.phase(c.phase).piece(c.up ? piece.high : piece.low, c.up);
  }

  template <class M>
  void serialize(M& m) {
    const auto size = pieces_.size();
    m(pieces_);
    if constexpr (M::reading)
      if (pieces_.size() != size) throw MemoryError("the snapshot has other torque tables");
  }

 private:
  /// Rounding of a StepCourse and its bounds.
  static constexpr double course_rounding = 1e-12;
  template <class State, class At>
  static StepCourse course_of(const System& system, int k, double t0, double t1, const State& x0,
                              const State& x1, At at) {
    const auto speed = [&](const State& x) {
      return system.phase(k).at(x.data(), x.data() + system.n()).value;
    };
    std::array<double, StepCourse::degree + 1> w{};
    w.front() = speed(x1);
    for (std::size_t j = 1; j < StepCourse::degree; ++j) w[j] = speed(at(StepCourse::time(t0, t1, j)));
    w.back() = speed(x0);
    return {t0, t1, w};
  }
  /// Scale of a speed: its greatest kink.
  static double speed_of(const Phase& phase) {
    double most = 0;
    for (const double kink : phase.kinks) most = std::max(most, std::abs(kink));
    return most > 0 ? most : 1;
  }
  /// Secants over the ends of real steps. On a steep piece a speed follows an equilibrium: its rate there
  /// is that of its error, and an implicit method's interpolation is less accurate than its steps.
  template <class Method, class F>
  void land_on_speed(const System& system, Method& method, F& f, Crossing& c) const {
    if (c.t <= method.t_old) return land_at(method, f, c.t);
    const double accepted = 1e-15 * speed_of(system.phase(c.phase));
    double before = method.t_old, value_before = rest(system, c.phase, c.up, method.x_old).value;
    for (int i = 0; i < 8; ++i) {
      method.land(f, c.t);
      const double value = rest(system, c.phase, c.up, method.x).value;
      const double rate = (value - value_before) / (c.t - before);
      if (std::abs(value) <= accepted || rate == 0 || !std::isfinite(rate)) return;
      const double next = c.t - value / rate;
      if (!(next > method.t_old) || std::abs(next - c.t) <= 2e-16 * c.t) return;
      if (std::abs(next - c.t) > 0.5 * (c.t - method.t_old)) return;  // grazing: keep the bracketed root
      before = c.t, value_before = value;
      c.t = next;
    }
  }
  static double rounding(const Piece& piece) {
    const auto size = [](double x) { return std::isfinite(x) ? std::abs(x) : 0; };
    return 1e-15 * std::max({1.0, size(piece.low), size(piece.high)});
  }
  std::vector<Piece> pieces_;
};

/// Limits of controllers: finds the first time in a step at which the demand of a controller reaches
/// its limit, so that the step can end there. With w the demand over the limit, the torque or force
/// is min(max(w, −1), 1) times the limit: it has a kink at w = ±1.
///
/// The search represents w on the dense output of the step by a polynomial (crossing.hpp), whose
/// bounds exclude that a demand crosses a limit and returns unseen. Values within `margin` of ±1, or
/// within rounding, belong to neither side: a step that begins at the limit begins on the side that
/// the motion enters. There is therefore no state beyond that of the motion. Where the motion on both
/// sides leads back to the limit (an integral that stops there), the demand slides along it: a return
/// within a thousandth of the step is no crossing, and error control bounds the steps.
class Limits {
 public:
  /// Of w, where integrators restart at the crossing.
  static constexpr double rounding = 1e-12;
  struct Crossing {
    int limiter = -1;
    double border = 0;  ///< ±1
    double t = 0;       ///< s
    bool found() const { return limiter >= 0; }
  };
  struct Interval {
    double t_old, t;  ///< s
  };

  /// The first crossing within the last step of `step`, before `before` (s). at(t): the state (q, v,
  /// ..., with the first-order states from `offset` on).
  template <class Step, class At>
  Crossing first(const System& system, int offset, const Step& step, double before, double margin, At at) {
    Crossing found;
    const auto n = static_cast<std::size_t>(system.limiters());
    if (n == 0 || !(step.t > step.t_old)) return found;
    found.t = before;
    samples_.resize(n);
    for (std::size_t k = 0; k <= StepCourse::degree; ++k) {
      const double t = StepCourse::time(step.t_old, step.t, k);
      evaluate(system, offset, t, at(t));
      for (std::size_t i = 0; i < n; ++i) samples_[i][k] = w_[i].share;
    }
    for (std::size_t i = 0; i < n; ++i) {
      const StepCourse course(step.t_old, step.t, samples_[i]);
      if (!std::isfinite(course.acceleration())) continue;
      const double start = samples_[i].back(), rate = course.rate(step.t_old);
      const double slack = std::max({margin, rounding * course.largest(), noise(w_[i], step.t, rate)});
      for (const auto& end : ends(start, rate, slack)) {
        if (!end.finite()) continue;
        const auto left = [&](double w, double t) {
          return Watched{end.sign * (w - end.border), end.sign * course.rate(t)};
        };
        const auto look = [&](double t) {
          evaluate(system, offset, t, at(t));
          return left(w_[i].share, t);
        };
        auto from = left(start, step.t_old);
        const bool at_limit = std::abs(from.value) <= slack;
        if (at_limit) from.value = 0;
        double unseen = 0;
        const auto t = first_loss(look, step.t_old, step.t, from, left(samples_[i].front(), step.t),
                                  {GapMotion::Shape::straight, 0, course.acceleration(), 0}, slack, unseen);
        if (!t || (at_limit && *t - step.t_old <= 1e-3 * (step.t - step.t_old))) continue;
        if (*t < found.t) found = {static_cast<int>(i), end.border, *t};
      }
    }
    if (!found.found()) found.t = 0;
    return found;
  }

  /// Ends the last step of `method` at a crossing.
  template <class Method, class F>
  void land(const System& system, int offset, Method& method, F& f, Crossing& c) {
    land_on_gap(method, f, c.t, rounding, [&] {
      const auto i = static_cast<std::size_t>(c.limiter);
      evaluate(system, offset, method.t, method.x);
      const double w = w_[i].share, ahead = 1e-3 * (method.t - method.t_old);
      moved_ = method.x;
      for (std::size_t k = 0; k < moved_.size(); ++k) moved_[k] += ahead * method.dxdt[k];
      evaluate(system, offset, method.t + ahead, moved_);
      return Watched{w - c.border, (w_[i].share - w) / ahead};
    });
  }

 private:
  /// An end of the range of w on one side of a limit.
  struct End {
    int sign;       ///< 1: the lower end, −1: the upper end
    double border;  ///< infinite: none
    bool finite() const { return std::isfinite(border); }
  };
  static std::array<End, 2> ends(double start, double rate, double slack) {
    const bool at_limit = std::abs(std::abs(start) - 1) <= slack;
    if (at_limit ? start * rate <= 0 : std::abs(start) <= 1) return {End{1, -1}, End{-1, 1}};
    const int side = start > 0 ? 1 : -1;
    return {End{side, static_cast<double>(side)}, End{-side, side * std::numeric_limits<double>::infinity()}};
  }
  /// Rounding of w: of its terms, and of the time.
  static double noise(const Saturation& w, double t, double rate) {
    return 8e-16 * (w.terms + std::abs(t * rate));
  }
  void evaluate(const System& system, int offset, double t, const std::vector<double>& x) {
    w_.resize(static_cast<std::size_t>(system.limiters()));
    system.saturations(t, x.data(), x.data() + system.n(), x.data() + offset, w_.data());
  }
  std::vector<Saturation> w_;
  std::vector<double> moved_;
  std::vector<std::array<double, StepCourse::degree + 1>> samples_;
};

}  // namespace freeplay
