// Phases: angles, distances and speeds at which tables and one-way forces have kinks. It keeps the
// present piece of each, and finds the first crossing of a kink in a step. A method that samples a
// table only at its stages may pass over whole pulses. Each table is therefore restricted to its
// present piece, on which it is smooth, and every kink is an event, located like a contact onset. A
// speed that approaches an equilibrium between two kinks crosses neither.
#pragma once

#include <optional>
#include <vector>

#include "formulations/integrators/crossing.hpp"
#include "formulations/integrators/step_course.hpp"
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
        const auto motion = phase.speed ? GapMotion{GapMotion::Shape::straight, 0, course.bend(), 0}
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

}  // namespace freeplay
