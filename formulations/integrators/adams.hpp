// The predictor-corrector method of Adams, Bashforth and Moulton with variable order (up to 8) and
// step (AdamsHistory); cubic Hermite interpolation between steps. A step to an event is made by
// Fehlberg's 7(8), because the history is discarded there anyway.
#pragma once

#include <boost/numeric/odeint/stepper/runge_kutta_fehlberg78.hpp>

#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>

#include "formulations/integrators/methods.hpp"
#include "values/memory.hpp"

namespace freeplay {

// AdamsHistory: the history of the method of Adams, Bashforth and Moulton with variable order k and
// step h, and its sums. With the modified divided differences φᵢ of the derivative and the
// coefficients gᵢ and βᵢ of the last steps' lengths, a step is
//
//     predictor    y* = y + Σ_{i<k} h gᵢ βᵢ φᵢ
//     differences  φ*₀ = f(y*),  φ*ᵢ = φ*ᵢ₋₁ − βᵢ₋₁ φᵢ₋₁
//     corrector    y₁ = y* + h g_k φ*_k,  and the differences anew with f(y₁)
//
// Source: Krogh, Shampine and Gordon, as in Boost.Odeint's adaptive_adams_bashforth_moulton, with its
// choice of the order. Each sum has the operations of Odeint in their order, so the results are bitwise
// identical; but it is one pass over the components with all orders at once. Norms are taken of the
// differences and multiplied afterwards, which rounds to the same number.
//
// Usage: see Adams::attempt(). All components are in units of their error scales. A table has, for each
// four components, the differences of all orders in turn, so that a pass reads one stream.

struct AdamsSums;  // adams.cpp

class AdamsHistory {
 public:
  using Vector = std::vector<double>;
  static constexpr int most_order = 8;

  /// For n components; forgets everything.
  void resize(std::size_t n);
  /// Begins at a state; the next step is of first order.
  void restart(const Vector& x, const Vector& scale);
  /// Begins the next step at the end of the last one.
  void advance() { y_.swap(y_new_); }
  /// Whether the derivative at the beginning of the step is missing: begin().
  bool empty() const { return steps_ == 1; }
  int order() const { return order_; }

  /// The state at the beginning of the step, in its own units.
  void state(Vector& x) const;
  /// Sets the coefficients of a step of length h (s) from t (s).
  void predict(double t, double h);
  /// Enters the first derivative.
  void begin(const Vector& dxdt);
  /// x = y*
  void extrapolate(Vector& x);
  /// x = y₁ by the derivative at y*. Returns the greatest error |h g_k φ*_k|, or NaN.
  double correct(const Vector& dxdt, Vector& x);
  /// Enters the derivative at y₁: the step is accepted.
  void confirm(const Vector& dxdt);
  /// Chooses the order of the next step, of length h (s), by the errors of neighbouring orders.
  void choose_order(double h);

  template <class M>
  void serialize(M& m) {
    const auto size = y_.size(), table = now_.size();
    m(order_, steps_, scale_, y_, y_new_, now_, before_, beta_, times_, error_above_);
    if constexpr (M::reading)
      if (scale_.size() != size || y_.size() != size || y_new_.size() != size || now_.size() != table ||
          before_.size() != table || order_ < 1 || order_ > most_order || steps_ < order_ ||
          steps_ > most_order + 1)
        throw MemoryError("the snapshot's integrator has another size, or is damaged");
  }

 private:
  static constexpr int entries = most_order + 2;  // differences of a component
  static constexpr std::size_t width = 4;         // components side by side

  AdamsSums sums();

  std::size_t n_ = 0;
  int order_ = 1, steps_ = 1;  // steps_: number of times in use
  double h_ = 0;
  Vector scale_, y_, y_new_;  // with room for whole groups of components
  Vector now_, before_;       // differences φ* of this step and φ of the last one
  /// Coefficients β of this step and the last but one, whose upper entries remain.
  std::array<std::array<double, most_order + 1>, 2> beta_{};
  std::array<double, most_order + 1> times_{};  // s, of the last steps
  std::array<double, most_order + 1> g_{};
  /// Norms of the differences of orders k − 2 to k + 1 at the last confirm().
  std::array<double, 4> greatest_{};
  double error_above_ = 0;  // of the order above, when it was last known
};

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
