// Rosenbrock: the implicit method of fourth order for stiff contacts and strong damping,
// numerics/rosenbrock4 with the exact Jacobian of the right-hand side (for example
// PenaltyDynamics::jacobian()). RosenbrockStep makes its steps, also for Relieved.
#pragma once

#include <algorithm>
#include <cmath>

#include "formulations/integrators/methods.hpp"
#include "numerics/rosenbrock4.hpp"

namespace freeplay {

/// Rosenbrock steps from the old state of a method to its new state.
class RosenbrockStep {
 public:
  RosenbrockStep(ErrorNorm norm, double first_step)
      : stepper_(0), norm_(std::move(norm)), first_step_(first_step), dt_(first_step) {}

  void make_room(std::size_t n) {
    stepper_ = Rosenbrock4(static_cast<int>(n));
    error_.resize(n);
    J_.resize(n * n);
    dfdt_.resize(n);
    linearised_ = false;
  }
  void begin() { dt_ = first_step_; }
  void limit(double h) { dt_ = std::min(dt_, h); }

  /// Makes one accepted step, not beyond t_end; `s` is already shifted. Returns false if there is
  /// none.
  template <class F>
  bool advance(F& f, MethodState& s, double t_end) {
    linearised_ = false;
    const double wish = dt_;
    for (;;) {
      const bool cut = s.t_old + dt_ >= t_end;
      const double h = cut ? t_end - s.t_old : dt_;
      const bool accepted = control(f, s, h);
      if (accepted) {
        if (cut) dt_ = std::max(dt_, wish);
        end(f, s, cut ? t_end : s.t_old + h);
        return true;
      }
      ++s.rejected;
      if (s.vanishing(dt_, first_step_)) return false;
    }
  }
  /// Makes a step of length h if its error is accepted; otherwise only s.x and s.dxdt are
  /// overwritten.
  template <class F>
  bool attempt(F& f, MethodState& s, double h) {
    linearised_ = false;
    if (!control(f, s, h)) return false;
    end(f, s, s.t_old + h);
    return true;
  }
  /// Makes one step of length h from the old state, whose Jacobian is computed once.
  template <class F>
  void make(F& f, MethodState& s, double h) {
    struct Context {
      F& f;
      MethodState& s;
      RosenbrockStep& self;
    } context{f, s, *this};
    Rosenbrock4::Problem problem;
    problem.context = &context;
    problem.side = [](void* c, const double* y, double* dydt, double at) {
      auto& [side, state, self] = *static_cast<Context*>(c);
      std::copy(y, y + state.x.size(), state.x.begin());
      side(state.x, state.dxdt, at);
      std::copy(state.dxdt.begin(), state.dxdt.end(), dydt);
    };
    problem.jacobian = [](void* c, const double*, double at, double* J, double* dfdt) {
      auto& [side, state, self] = *static_cast<Context*>(c);
      if (!self.linearised_) side.jacobian(state.x_old, at, self.J_.data(), self.dfdt_.data());
      self.linearised_ = true;
      std::copy(self.J_.begin(), self.J_.end(), J);
      std::copy(self.dfdt_.begin(), self.dfdt_.end(), dfdt);
    };
    stepper_.step(problem, s.x_old.data(), s.t_old, h, s.x.data(), error_.data());
  }
  template <class F>
  void end(F& f, MethodState& s, double t) {
    s.t = t;
    f(s.x, s.dxdt, t);
  }
  /// The Jacobian belongs to one step only and is not serialized.
  template <class M>
  void serialize(M& m) {
    m(dt_);
  }

 private:
  /// Makes a step, sets the length of the next one by its error, and returns whether the error is
  /// accepted.
  template <class F>
  bool control(F& f, MethodState& s, double h) {
    constexpr double shortest = 0.2;  // length of the next step over this one
    make(f, s, h);
    if (stepper_.damps_growth()) {
      dt_ = shortest * h;
      return false;
    }
    const double ratio = norm_.error(*this, s.x, s.dxdt, error_, h);
    // The error estimate is of third order, proportional to h⁴.
    dt_ = h * std::clamp(0.9 * std::pow(std::max(ratio, 1e-10), -0.25), shortest, 5.0);
    return ratio <= 1;
  }

  Rosenbrock4 stepper_;
  ErrorNorm norm_;
  double first_step_, dt_;
  bool linearised_ = false;  // J_ belongs to the old state
  Vector error_, J_, dfdt_;
};

class Rosenbrock : public MethodState {
 public:
  static constexpr bool may_creep = false, cubic = true;
  Rosenbrock(ErrorNorm norm, double first_step) : step_(std::move(norm), first_step) {}

  template <class F>
  void start(F& f, double at, const Vector& state) {
    if (x.size() != state.size()) step_.make_room(state.size());
    begin(at, state);
    f(x, dxdt, t);
  }
  void limit_step(double h) { step_.limit(h); }
  template <class F>
  bool step(F& f, double t_end) {
    shift();
    return step_.advance(f, *this, t_end);
  }
  template <class F>
  void land(F& f, double to) {
    step_.make(f, *this, to - t_old);
    step_.end(f, *this, to);
  }
  void interpolate(double at, Vector& out) const { hermite(at, out); }
  /// Accelerations at the ends of a stiff step may belong to layers far shorter than the step.
  void show(double at, std::size_t, Vector& out) const { hermite(at, out); }
  template <class M>
  void serialize(M& m) {
    m.part("rosenbrock4");
    MethodState::serialize(m);
    step_.serialize(m);
    if constexpr (M::reading) step_.make_room(x.size());
  }

 private:
  RosenbrockStep step_;
};

/// Relieved<Method>: an explicit method with an implicit one in reserve. A contact with steep
/// regularised friction limits an explicit method to steps of the friction's decay time, thousands
/// per contact, even if the motion is smooth; methods of high order find no accepted step at all.
/// The implicit method takes over until the mode changes if the explicit method fails, or if after
/// many steps in one mode an implicit step of twenty times their length passes the same error
/// control. If neither happens, the results are bitwise identical to those of the explicit method. A
/// method with a fixed step is relieved only if it fails or if modes chatter.
template <class Method>
class Relieved : public Method {
 public:
  /// `first_probe`: number of steps in one mode before an implicit one is tried; 0: only the
  /// explicit method is used.
  Relieved(Method method, const ErrorNorm& norm, double first_step, long first_probe = 2000)
      : Method(std::move(method)),
        implicit_(norm, first_step),
        affordable_(first_probe > 0),
        first_probe_(first_probe) {}

  template <class F>
  void start(F& f, double at, const Vector& state) {
    if (this->x.size() != state.size()) make_room(f, state.size());
    Method::start(f, at, state);
    forget();
  }
  /// Limits the length of the next step.
  void limit_step(double h) {
    limit_ = h;
    Method::limit_step(h);
  }
  /// Called when the right-hand side has a different form from here on.
  void new_mode() {
    // its history belongs to the time before
    if (stiff_) Method::limit_step(this->t - this->t_old);
    forget();
  }
  /// Switches to the implicit method: modes chatter, because no step of the explicit method is
  /// stable in them.
  void relieve() {
    if (stiff_ || !affordable_) return;
    stiff_ = true;
    ++reliefs_;
    implicit_.begin();
  }
  bool relieved() const { return stiff_; }
  /// Uses the explicit method only, from the start on: derivatives are those of its steps.
  void keep_explicit() {
    affordable_ = false;
    first_probe_ = 0;
  }
  /// How often the implicit method took over.
  long reliefs() const { return reliefs_; }
  template <class F>
  bool step(F& f, double t_end) {
    by_implicit_ = true;
    if (Method::may_creep && affordable_ && !stiff_ && ++steps_ == probe_at_) {
      probe_at_ *= 2;
      const double length = stiff_steps * (this->t - since_) / static_cast<double>(steps_ - counted_);
      since_ = this->t;
      counted_ = steps_;
      if (length < t_end - this->t) {
        this->shift();
        if (implicit_.attempt(f, *this, length)) {
          stiff_ = true;
          ++reliefs_;
          return true;
        }
        this->unshift();
      }
    }
    if (!stiff_) {
      by_implicit_ = false;
      if (Method::step(f, t_end)) {
        limit_ = INFINITY;
        return true;
      }
      if (Method::fixed_step || !affordable_) return false;  // a diverged result is shown as it is
      this->unshift();
      if (!finite(this->x) || !finite(this->dxdt)) {
        this->shift();
        return false;
      }
      relieve();
      implicit_.limit(limit_);  // the new mode has no known step length yet
      by_implicit_ = true;
    }
    this->shift();
    return implicit_.advance(f, *this, t_end);
  }
  template <class F>
  void land(F& f, double to) {
    if (!by_implicit_) return Method::land(f, to);
    implicit_.make(f, *this, to - this->t_old);
    implicit_.end(f, *this, to);
  }
  void interpolate(double at, Vector& out) const {
    if (by_implicit_)
      this->hermite(at, out);
    else
      Method::interpolate(at, out);
  }
  void show(double at, std::size_t n, Vector& out) const {
    if (by_implicit_)
      this->hermite(at, out);
    else
      Method::show(at, n, out);
  }
  void enclose(std::size_t n, MotionBounds& bounds) const {
    if (by_implicit_)
      MethodState::enclose(n, bounds);
    else
      Method::enclose(n, bounds);
  }
  template <class M>
  void serialize(M& m) {
    Method::serialize(m);
    m(stiff_, by_implicit_, steps_, counted_, probe_at_, since_, reliefs_, limit_);
    if constexpr (M::reading) {
      affordable_ = first_probe_ > 0 && this->x.size() <= most_unknowns;
      if (affordable_) implicit_.make_room(this->x.size());
    }
    implicit_.serialize(m);
  }

 private:
  static constexpr double stiff_steps = 20;
  /// Dense solves with more unknowns cost more than the short steps of an explicit method.
  static constexpr std::size_t most_unknowns = 400;

  /// Called before the first step, so that no step allocates.
  template <class F>
  void make_room(F& f, std::size_t n) {
    affordable_ = first_probe_ > 0 && n <= most_unknowns;
    if (!affordable_) return;
    implicit_.make_room(n);
    f.reserve_jacobian();
  }

  static bool finite(const Vector& x) {
    return std::ranges::all_of(x, [](double y) { return std::isfinite(y); });
  }
  void forget() {
    stiff_ = false;
    steps_ = counted_ = 0;
    probe_at_ = first_probe_;
    since_ = this->t;
  }
  RosenbrockStep implicit_;
  bool stiff_ = false, affordable_;
  bool by_implicit_ = false;  // the last step was implicit; its mode may have ended since
  long first_probe_;
  long steps_ = 0, counted_ = 0, probe_at_ = first_probe_;  // in this mode
  double limit_ = INFINITY;                                 // s, limit of the next step
  double since_ = 0;  // s, time of the last probe or the beginning of the mode
  long reliefs_ = 0;
};

}  // namespace freeplay
