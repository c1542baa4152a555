// Integrators of Boost.Odeint behind a small common interface. A Method has
//
//     start(f, t, x)          starts at a state (after every event, with a new right-hand side);
//     step(f, t_end)          makes one accepted step, not beyond t_end; false if there is none;
//     renew(f)                evaluates the right-hand side at the present state, if it changed;
//     land(f, t)              repeats the last step so that it ends at t, t_old < t ≤ its end;
//     interpolate(t, x)       gives the state within the last step;
//     cubic                   whether that is hermite() of each component;
//     show(t, n, x)           the same for results, by a higher order if the method has one;
//     enclose(n, bounds)      bounds the rates and accelerations of interpolate();
//     relieve(), reliefs()    switches to an implicit method where modes chatter; how often it did;
//     new_mode()              called when the right-hand side has a different form from here on;
//     serialize(m)             serializes or restores all data that further steps depend on
//                             (values/memory.hpp), so that a new method with the same arguments
//                             continues bit by bit; except the dense output of the last step.
//
// Landing repeats the step instead of interpolating, so that an event has the accuracy of the
// method.
#pragma once

#include <boost/numeric/odeint/stepper/controlled_runge_kutta.hpp>
#include <boost/numeric/odeint/stepper/runge_kutta4.hpp>
#include <boost/numeric/odeint/stepper/runge_kutta_dopri5.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <functional>
#include <span>
#include <vector>

#include "dynamics/gap_motion.hpp"
#include "formulations/integrators/vector_algebra.hpp"
#include "values/memory.hpp"

namespace freeplay {

using Vector = std::vector<double>;

/// Error norm of a step, relative to the accepted error:
///
///     max |error_i| / (tolerance (absolute_i + relative_i |x_i|)).
///
/// Components with infinite absolute_i, or after the last of them, have no error control; but any
/// component that is not finite rejects the step.
struct ErrorNorm {
  Vector absolute, relative;
  double tolerance = 1e-8;

  template <class Algebra, class State, class Deriv, class Error, class Time>
  double error(Algebra&, const State& x, const Deriv&, Error& e, Time) const {
    constexpr double refused = 1e10;
    double worst = 0;
    for (std::size_t i = 0; i < absolute.size(); ++i) {
      const double accepted = tolerance * (absolute[i] + relative[i] * std::abs(x[i]));
      const double ratio = std::abs(e[i]) / accepted;
      if (!(ratio < refused)) return refused;
      worst = std::max(worst, ratio);
    }
    for (std::size_t i = absolute.size(); i < e.size(); ++i)
      if (!std::isfinite(e[i])) return refused;
    return worst;
  }
};

struct MethodState {
  /// Whether the method chooses its steps, which a stiff motion may make very short.
  static constexpr bool may_creep = true;
  /// Whether the method has no error control; its result may be wrong for stiff motions.
  static constexpr bool fixed_step = false;
  /// Whether the method interpolates by a polynomial of its own order, because its steps are too
  /// long for a low one.
  static constexpr bool long_steps = false;
  static constexpr bool cubic = false;
  double t_old = 0, t = 0;
  Vector x_old, x, dxdt_old, dxdt;
  long rejected = 0;

  void resize(std::size_t n) {
    for (auto* y : {&x_old, &x, &dxdt_old, &dxdt}) y->assign(n, 0);
  }
  void begin(double at, const Vector& state) {
    if (x.size() != state.size()) resize(state.size());
    t_old = t = at;
    std::copy(state.begin(), state.end(), x.begin());
  }
  void shift() {
    std::swap(x, x_old);
    std::swap(dxdt, dxdt_old);
    t_old = t;
  }
  /// Reverts shift(), for a step that was not made.
  void unshift() {
    std::swap(x, x_old);
    std::swap(dxdt, dxdt_old);
    t = t_old;
  }
  void new_mode() {}
  void relieve() {}
  bool relieved() const { return false; }
  long reliefs() const { return 0; }
  /// Cubic Hermite interpolation between the ends of the last step.
  void hermite(double at, Vector& out) const {
    const auto of = hermite_weights(at);
    for (std::size_t i = 0; i < x.size(); ++i) out[i] = hermite(of, i);
  }
  /// The same for some components only.
  void hermite(double at, std::span<const int> components, Vector& out) const {
    const auto of = hermite_weights(at);
    for (const int i : components)
      out[static_cast<std::size_t>(i)] = hermite(of, static_cast<std::size_t>(i));
  }
  /// The state within the last step for results; the first n components are coordinates, followed
  /// by their rates. These are interpolated by the quintic through positions, rates and
  /// accelerations at both ends, and by its derivative. If a motion without contacts allows long
  /// steps of a method of high order, the cubic has an error of h⁴/384 of a fourth derivative.
  void show(double at, std::size_t n, Vector& out) const {
    hermite(at, out);
    const double h = t - t_old, s = (at - t_old) / h, r = 1 - s, bubble = s * s * r * r;
    for (std::size_t i = 0; i < n; ++i) {
      const double moved = x[i] - x_old[i], v0 = x_old[n + i], v1 = x[n + i], a0 = dxdt_old[n + i],
                   a1 = dxdt[n + i];
      // The part of the displacement that the cubic through rates and accelerations misses; for
      // short steps only its rounding error.
      const double missed = moved - 0.5 * h * (v0 + v1) - h * h / 12 * (a0 - a1);
      if (!(std::abs(missed) > 1e-13 * (std::abs(x_old[i]) + std::abs(x[i])))) continue;
      const double bend0 = 0.5 * (h * h * a0 - (6 * moved - h * (4 * v0 + 2 * v1)));
      const double bend1 = 0.5 * (h * h * a1 + (6 * moved - h * (2 * v0 + 4 * v1)));
      out[i] += bubble * (r * bend0 + s * bend1);
      out[n + i] += 30 * bubble * missed / h;
    }
  }
  /// Bounds on the motion of the last step, for n coordinates, which come first in x, followed by
  /// their rates.
  void enclose(std::size_t n, MotionBounds& bounds) const {
    bounds.enclose(t - t_old, n, x_old.data(), x_old.data() + n, dxdt_old.data() + n, x.data(), x.data() + n,
                   dxdt.data() + n);
  }
  template <class F>
  void renew(F& f) {
    f(x, dxdt, t);
  }
  template <class M>
  void serialize(M& m) {
    m(t_old, t, x_old, x, dxdt_old, dxdt, rejected);
    if constexpr (M::reading)
      for (const auto* y : {&x_old, &dxdt_old, &dxdt})
        if (y->size() != x.size())
          throw MemoryError("the snapshot's integrator has states of different sizes");
  }
  /// Weights of x_old, x and their rates.
  std::array<double, 4> hermite_weights(double at) const {
    const double h = t - t_old, s = (at - t_old) / h, r = 1 - s;
    return {r * r * (1 + 2 * s), s * s * (3 - 2 * s), h * s * r * r, -h * s * s * r};
  }
  double hermite(const std::array<double, 4>& of, std::size_t i) const {
    return of[0] * x_old[i] + of[1] * x[i] + of[2] * dxdt_old[i] + of[3] * dxdt[i];
  }
  /// Whether a step is so short that rounding dominates.
  bool vanishing(double dt, double first) const {
    return !(dt > 4e-16 * std::abs(t)) || !(dt > 1e-14 * first);
  }
};

/// Dormand and Prince's explicit 5(4) pair with step control and its fourth-order dense output.
class Dopri5 : public MethodState {
  using Controlled =
      boost::numeric::odeint::controlled_runge_kutta<boost::numeric::odeint::runge_kutta_dopri5<Vector>,
                                                     ErrorNorm>;

 public:
  Dopri5(const ErrorNorm& norm, double first_step)
      : stepper_(norm), first_step_(first_step), dt_(first_step) {}

  template <class F>
  void start(F& f, double at, const Vector& state) {
    if (x.size() != state.size()) stepper_.stepper().adjust_size(state);
    begin(at, state);
    f(x, dxdt, t);
  }
  /// Limits the length of the next step.
  void limit_step(double h) { dt_ = std::min(dt_, h); }

  template <class F>
  bool step(F& f, double t_end) {
    shift();
    const double wish = dt_;
    bool cut = t + dt_ >= t_end;
    if (cut) dt_ = t_end - t;
    while (stepper_.try_step(std::ref(f), x_old, dxdt_old, t, x, dxdt, dt_) !=
           boost::numeric::odeint::success) {
      ++rejected;
      cut = false;
      if (vanishing(dt_, first_step_)) {
        dt_ = wish;  // a failed step does not determine the next step length
        return false;
      }
    }
    if (cut) {
      t = t_end;
      dt_ = std::max(dt_, wish);
    }
    return true;
  }
  template <class F>
  void land(F& f, double to) {
    stepper_.stepper().do_step(std::ref(f), x_old, dxdt_old, t_old, x, dxdt, to - t_old);
    t = to;
  }
  void interpolate(double at, Vector& out) const {
    stepper_.stepper().calc_state(at, out, x_old, dxdt_old, t_old, x, dxdt, t);
  }
  void show(double at, std::size_t, Vector& out) const { interpolate(at, out); }
  /// The quartic deviates from the cubic through rates and accelerations by a multiple of s²(1 −
  /// s)². The deviation is known from the middle, and its rate is at most 3.1/h times its size.
  void enclose(std::size_t n, MotionBounds& bounds) const {
    MethodState::enclose(n, bounds);
    middle_.resize(x.size());
    interpolate(0.5 * (t_old + t), middle_);
    const double h = t - t_old;
    for (std::size_t i = 0; i < n; ++i) {
      const double cubic = 0.5 * (x_old[n + i] + x[n + i]) + 0.125 * h * (dxdt_old[n + i] - dxdt[n + i]);
      bounds.widen(i, std::abs(middle_[n + i] - cubic), 3.1);
    }
  }
  /// The stepper of Odeint keeps no data between steps: every stage is computed anew.
  template <class M>
  void serialize(M& m) {
    m.part("dopri5");
    MethodState::serialize(m);
    m(dt_);
    if constexpr (M::reading) stepper_.stepper().adjust_size(x);
  }

 private:
  Controlled stepper_;
  double first_step_, dt_;
  mutable Vector middle_;
};

/// The classical fourth-order method with a fixed step; cubic Hermite interpolation between steps.
class Rk4 : public MethodState {
 public:
  static constexpr bool may_creep = false, fixed_step = true, cubic = true;
  explicit Rk4(double step) : h_(step) {}
  double length() const { return h_; }

  template <class F>
  void start(F& f, double at, const Vector& state) {
    if (x.size() != state.size()) stepper_.adjust_size(state);
    begin(at, state);
    f(x, dxdt, t);
  }
  void limit_step(double) {}

  template <class F>
  bool step(F& f, double t_end) {
    shift();
    land(f, t_old + h_ * (1 + 1e-9) >= t_end ? t_end : t_old + h_);
    for (double y : x)
      if (!std::isfinite(y)) return false;
    return true;
  }
  template <class F>
  void land(F& f, double to) {
    stepper_.do_step(std::ref(f), x_old, dxdt_old, t_old, x, to - t_old);
    t = to;
    f(x, dxdt, t);
  }
  void interpolate(double at, Vector& out) const { hermite(at, out); }
  template <class M>
  void serialize(M& m) {
    m.part("rk4");
    MethodState::serialize(m);
    if constexpr (M::reading) stepper_.adjust_size(x);
  }

 private:
  boost::numeric::odeint::runge_kutta4<Vector> stepper_;
  double h_;
};

// A right-hand side in units of its error scales, for methods whose error control has a single
// absolute tolerance.

/// Components without a scale have
/// units so large that their error never counts.
class ScaledSide {
 public:
  explicit ScaledSide(ErrorNorm norm) : norm_(std::move(norm)) {}
  /// Sets the scales at a state: absolute_i + relative_i |x_i|.
  void measure(const Vector& x) {
    constexpr double unmeasured = 1e9;
    scale_.assign(x.size(), unmeasured);
    for (std::size_t i = 0; i < norm_.absolute.size(); ++i)
      if (std::isfinite(norm_.absolute[i]))
        scale_[i] = norm_.absolute[i] + norm_.relative[i] * std::abs(x[i]);
    x_.resize(x.size());
    dxdt_.resize(x.size());
  }
  void to_scaled(const Vector& x, Vector& y) const {
    for (std::size_t i = 0; i < x.size(); ++i) y[i] = x[i] / scale_[i];
  }
  void from_scaled(const Vector& y, Vector& x) const {
    for (std::size_t i = 0; i < x.size(); ++i) x[i] = y[i] * scale_[i];
  }
  template <class F>
  void evaluate(F& f, const Vector& y, Vector& dydt, double t) {
    from_scaled(y, x_);
    f(x_, dxdt_, t);
    to_scaled(dxdt_, dydt);
  }
  /// The derivative of the last evaluation, in the units of x.
  const Vector& last() const { return dxdt_; }
  const Vector& scale() const { return scale_; }
  double tolerance() const { return norm_.tolerance; }
  /// Only the scales of the last start are serialized. `size`: of a state.
  template <class M>
  void serialize(M& m, std::size_t size) {
    m(scale_);
    if constexpr (M::reading) {
      if (!scale_.empty() && scale_.size() != size)
        throw MemoryError("the snapshot's integrator has another size, or is damaged");
      x_.resize(size);
      dxdt_.resize(size);
    }
  }

 private:
  ErrorNorm norm_;
  Vector scale_, x_, dxdt_;
};

// Dormand and Prince's method for columns of derivatives along a motion.

/// Dormand and Prince's coefficients of the six stages of the result of fifth order.
struct DormandPrince {
  static constexpr double c[6] = {0, 1.0 / 5, 3.0 / 10, 4.0 / 5, 8.0 / 9, 1};
  static constexpr double a[6][5] = {
      {},
      {1.0 / 5},
      {3.0 / 40, 9.0 / 40},
      {44.0 / 45, -56.0 / 15, 32.0 / 9},
      {19372.0 / 6561, -25360.0 / 2187, 64448.0 / 6561, -212.0 / 729},
      {9017.0 / 3168, -355.0 / 33, 46732.0 / 5247, 49.0 / 176, -5103.0 / 18656},
  };
  static constexpr double b[6] = {35.0 / 384, 0, 500.0 / 1113, 125.0 / 192, -2187.0 / 6784, 11.0 / 84};

  /// Weights of the differences from embedded results. Third order: by six stages; all conditions of this
  /// order hold, since stages 3 and 4 have stage order 2. Fourth order: the seventh stage is at the end of
  /// the step.
  static constexpr double third[6] = {b[0] - 7.0 / 72, 0, b[2] - 4.0 / 9, b[3] - 11.0 / 24, b[4], b[5]};
  static constexpr double fourth[7] = {71.0 / 57600,      0,          -71.0 / 16695, 71.0 / 1920,
                                       -17253.0 / 339200, 22.0 / 525, -1.0 / 40};
};

}  // namespace freeplay
