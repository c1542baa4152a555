// The predictor-corrector method of Adams, Bashforth and Moulton with variable order (up to 8) and
// step (adams_history.hpp); cubic Hermite interpolation between steps. A step to an event is made by
// Fehlberg's 7(8), because the history is discarded there anyway.
#pragma once

#include <boost/numeric/odeint/stepper/runge_kutta_fehlberg78.hpp>

#include "formulations/integrators/adams_history.hpp"
#include "formulations/integrators/methods.hpp"
#include "formulations/integrators/scaled_side.hpp"

namespace freeplay {

/// Step control on the greatest scaled error; a step is accepted if the proposed step is at least
/// 0.9 of it.
struct AdamsAdjuster {
  double tolerance = 1e-8;
  /// The next step after one of length h (s) of this order; `error` may be NaN.
  double next(int order, double h, double error) const {
    constexpr double refused = 1e10;
    const double share = error / tolerance, ratio = share < refused ? share : refused;
    const double factor = 0.9 * std::pow(ratio, -1.0 / (order + 1));
    return h * std::min(ratio <= 1 ? std::max(1.0, 0.9 * factor) : factor, 2.0);
  }
  static bool accepts(double h, double next) { return next / h >= 0.9; }
};

class Adams : public MethodState {
 public:
  static constexpr bool cubic = true;
  Adams(ErrorNorm norm, double first_step)
      : side_(std::move(norm)), adjuster_{side_.tolerance()}, first_step_(first_step), dt_(first_step) {}

  template <class F>
  void start(F& f, double at, const Vector& state) {
    if (x.size() != state.size()) make_room(state);
    begin(at, state);
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
    shift();
    cut_short_ = false;
    if (fresh_) {
      side_.measure(x_old);
      history_.restart(x_old, side_.scale());
      fresh_ = false;
    } else {
      history_.advance();
    }
    const double wish = dt_;
    bool cut = t + dt_ >= t_end;
    if (cut) dt_ = t_end - t;
    while (!attempt(f)) {
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
    x.swap(trial_);  // an accepted step ends by evaluating at its end
    dxdt.swap(slope_);
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
    m(dt_, fresh_, cut_short_);
    if constexpr (M::reading) make_room(x);
    side_.serialize(m, x.size());
    m(history_);
  }

 private:
  void make_room(const Vector& state) {
    landing_.adjust_size(state);
    history_.resize(state.size());
    trial_.resize(state.size());
    slope_.resize(state.size());
  }
  /// One attempt at a step of dt_, which becomes the length of the next one; false if its error is
  /// too large.
  template <class F>
  bool attempt(F& f) {
    const double h = dt_;
    history_.predict(t, h);
    if (history_.empty()) {
      history_.state(trial_);
      f(trial_, slope_, t);
      history_.begin(slope_);
    }
    history_.extrapolate(trial_);
    f(trial_, slope_, t + h);
    dt_ = adjuster_.next(history_.order(), h, history_.correct(slope_, trial_));
    if (!AdamsAdjuster::accepts(h, dt_)) return false;
    f(trial_, slope_, t + h);
    history_.confirm(slope_);
    t += h;
    history_.choose_order(dt_);
    return true;
  }

  ScaledSide side_;
  AdamsHistory history_;
  AdamsAdjuster adjuster_;
  boost::numeric::odeint::runge_kutta_fehlberg78<Vector> landing_;
  double first_step_, dt_;
  bool fresh_ = true, cut_short_ = false;
  Vector trial_, slope_;  // at the trial state
};

}  // namespace freeplay
