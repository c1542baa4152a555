// Methods of Boost.Odeint whose error control uses a single absolute tolerance: extrapolation by
// Bulirsch and Stoer, and the method of Adams. They integrate in units of the error scales.
#pragma once

#include <boost/numeric/odeint/stepper/runge_kutta_fehlberg78.hpp>

#include "formulations/integrators/methods.hpp"
#include "formulations/integrators/odeint_memory.hpp"

namespace freeplay {

/// ScaledSide: a right-hand side in units of its error scales. Components without a scale have
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
  double tolerance() const { return norm_.tolerance; }
  /// Only the scales of the last start are serialized. `size`: of a state.
  template <class M>
  void serialize(M& m, std::size_t size) {
    m(scale_);
    if constexpr (M::reading) {
      odeint_memory::require(scale_.empty() || scale_.size() == size);
      x_.resize(size);
      dxdt_.resize(size);
    }
  }

 private:
  ErrorNorm norm_;
  Vector scale_, x_, dxdt_;
};

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

/// The predictor-corrector method of Adams, Bashforth and Moulton with variable order (up to 8) and
/// step; cubic Hermite interpolation between steps. A step to an event is made by Fehlberg's 7(8),
/// because the history is discarded there anyway.
class Adams : public MethodState {
 public:
  static constexpr bool cubic = true;
  Adams(ErrorNorm norm, double first_step)
      : side_(std::move(norm)),
        stepper_(AdamsAdjuster{side_.tolerance()}),
        first_step_(first_step),
        dt_(first_step) {}

  template <class F>
  void start(F& f, double at, const Vector& state) {
    if (x.size() != state.size()) landing_.adjust_size(state);
    begin(at, state);
    y_.resize(x.size());
    y_new_.resize(x.size());
    fresh_ = true;
    f(x, dxdt, t);
  }
  void limit_step(double h) {
    // A restart is of first order and needs a step far shorter than the previous one of high order.
    // Several contacts that close simultaneously cause only one restart.
    dt_ = std::min({cut_short_ ? dt_ : 1e-2 * dt_, h, first_step_});
    fresh_ = cut_short_ = true;
  }
  template <class F>
  void renew(F& f) {
    if (!fresh_) limit_step(dt_);
    MethodState::renew(f);
  }
  template <class F>
  bool step(F& f, double t_end) {
    const auto scaled = [&](const Vector& y, Vector& dydt, double at) { side_.evaluate(f, y, dydt, at); };
    shift();
    cut_short_ = false;
    if (fresh_) {
      side_.measure(x_old);
      side_.to_scaled(x_old, y_);
      stepper_.reset();
      fresh_ = false;
    } else {
      std::swap(y_, y_new_);
    }
    const double wish = dt_;
    bool cut = t + dt_ >= t_end;
    if (cut) dt_ = t_end - t;
    while (stepper_.try_step(scaled, y_, t, y_new_, dt_) != boost::numeric::odeint::success) {
      ++rejected;
      cut = false;  // a shorter step ends before t_end
      dt_ = std::min(dt_, t_end - t);
      if (vanishing(dt_, first_step_)) {
        dt_ = wish;  // a failed step does not determine the next step length
        return false;
      }
    }
    if (cut) dt_ = std::max(dt_, wish);
    if (std::abs(t - t_end) <= 4e-16 * t_end) t = t_end;
    side_.from_scaled(y_new_, x);
    dxdt = side_.last();  // an accepted step ends by evaluating at its end
    return true;
  }
  template <class F>
  void land(F& f, double to) {
    landing_.do_step(std::ref(f), x_old, dxdt_old, t_old, x, to - t_old);
    t = to;
    fresh_ = true;
    f(x, dxdt, t);
  }
  void interpolate(double at, Vector& out) const { hermite(at, out); }
  template <class M>
  void serialize(M& m) {
    m.part("adams");
    MethodState::serialize(m);
    m(dt_, fresh_, cut_short_, y_, y_new_);
    if constexpr (M::reading) {
      odeint_memory::require(y_.size() == x.size() && y_new_.size() == x.size());
      landing_.adjust_size(x);
    }
    side_.serialize(m, x.size());
    odeint_memory::serialize(m, stepper_, x.size());
  }

 private:
  ScaledSide side_;
  AdamsStepper stepper_;
  boost::numeric::odeint::runge_kutta_fehlberg78<Vector> landing_;
  double first_step_, dt_;
  bool fresh_ = true, cut_short_ = false;
  Vector y_, y_new_;
};

}  // namespace freeplay
