// The extrapolation of Bulirsch and Stoer by Boost.Odeint, whose error control uses a single absolute
// tolerance: it integrates in units of the error scales.
#pragma once

#include "formulations/integrators/methods.hpp"
#include "formulations/integrators/odeint_memory.hpp"

namespace freeplay {

/// Bulirsch and Stoer's extrapolation with dense output of the same order. Events end on the
/// interpolant.
class BulirschStoer : public MethodState {
 public:
  static constexpr bool long_steps = true;
  BulirschStoer(ErrorNorm norm, double first_step)
      : side_(std::move(norm)),
        stepper_(side_.tolerance(), 0.0, 1.0, 0.0, 0.0, true),
        first_step_(first_step),
        dt_(first_step) {}

  template <class F>
  void start(F& f, double at, const Vector& state) {
    begin(at, state);
    y_.resize(x.size());
    fresh_ = true;
    f(x, dxdt, t);
  }
  void limit_step(double h) {
    dt_ = std::min(dt_, h);
    fresh_ = true;  // called after an event: the history belongs to another mode
  }
  template <class F>
  void renew(F& f) {
    fresh_ = true;
    MethodState::renew(f);
  }
  template <class F>
  bool step(F& f, double t_end) {
    const auto scaled = [&](const Vector& y, Vector& dydt, double at) {
      side_.evaluate(f, y, dydt, at);
      double sum = 0;
      for (const double slope : dydt) sum += slope;
      if (!std::isfinite(sum)) throw NotFinite();
    };
    shift();
    if (fresh_ || t + dt_ > t_end) {
      if (fresh_) {
        side_.measure(x_old);
        stepper_.reset();
      }
      const double wish = dt_;
      side_.to_scaled(x_old, y_);
      stepper_.initialize(y_, t, std::min(dt_, t_end - t));
      fresh_ = false;
      wish_ = wish;
    }
    while (!attempt(scaled)) {
      ++rejected;
      const double shorter = 0.25 * stepper_.current_time_step();
      if (vanishing(shorter, first_step_)) return false;
      side_.to_scaled(x_old, y_);
      stepper_.reset();
      stepper_.initialize(y_, t, shorter);
    }
    t = stepper_.current_time();
    dt_ = std::max(stepper_.current_time_step(), t >= t_end ? wish_ : 0.0);
    // The sum of substeps may miss the end of the step by rounding; the rest is no step.
    if (std::abs(t - t_end) <= std::max(4e-16 * t_end, 1e-12 * (t_end - t_old))) t = t_end;
    side_.from_scaled(stepper_.current_state(), x);
    dxdt = side_.last();  // the step ends by evaluating at its end
    return !vanishing(t - t_old, first_step_) && std::isfinite(x.front());
  }
  template <class F>
  void land(F& f, double to) {
    interpolate(to, x);
    t = to;
    fresh_ = true;
    f(x, dxdt, t);
  }
  void interpolate(double at, Vector& out) const {
    stepper_.calc_state(at, y_);
    side_.from_scaled(y_, out);
  }
  void show(double at, std::size_t, Vector& out) const { interpolate(at, out); }
  /// The interpolant is of high degree. Its deviation from the cubic is evaluated at seven places;
  /// the rate of a polynomial of degree 8 over a time h is at most 128/h times its size (Markov).
  void enclose(std::size_t n, MotionBounds& bounds) const {
    MethodState::enclose(n, bounds);
    const double h = t - t_old;
    middle_.resize(x.size());
    apart_.assign(n, 0);
    for (int k = 1; k < 8; ++k) {
      const double s = k / 8.0, r = 1 - s;
      interpolate(t_old + s * h, middle_);
      for (std::size_t i = 0; i < n; ++i) {
        const std::size_t j = n + i;
        const double cubic = r * r * (1 + 2 * s) * x_old[j] + s * s * (3 - 2 * s) * x[j] +
                             h * s * r * (r * dxdt_old[j] - s * dxdt[j]);
        apart_[i] = std::max(apart_[i], std::abs(middle_[j] - cubic));
      }
    }
    for (std::size_t i = 0; i < n; ++i) bounds.widen(i, apart_[i], 128);
  }
  template <class M>
  void serialize(M& m) {
    m.part("bulirsch-stoer");
    MethodState::serialize(m);
    m(dt_, wish_, fresh_);
    if constexpr (M::reading) y_.resize(x.size());
    side_.serialize(m, x.size());
    odeint_memory::serialize(m, stepper_, y_);
  }

 private:
  /// A step too long to factorise the constraints within it; the step control of Odeint does not
  /// handle NaN.
  struct NotFinite : std::exception {};
  template <class F>
  bool attempt(const F& scaled) {
    try {
      stepper_.do_step(scaled);
      return true;
    } catch (const std::exception&) {  // NotFinite, or Odeint's exception if no step is accepted
      return false;
    }
  }

  ScaledSide side_;
  BulirschStoerStepper stepper_;
  double first_step_, dt_, wish_ = 0;
  bool fresh_ = true;
  mutable Vector y_, middle_, apart_;
};

}  // namespace freeplay
