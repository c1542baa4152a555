// Relieved<Method>: an explicit method with an implicit one in reserve. A contact with steep
// regularised friction limits an explicit method to steps of the friction's decay time, thousands
// per contact, even if the motion is smooth; methods of high order find no accepted step at all.
// The implicit method takes over until the mode changes if the explicit method fails, or if after
// many steps in one mode an implicit step of twenty times their length passes the same error
// control. If neither happens, the results are those of the explicit method in every digit. A
// method with a fixed step is relieved only if it fails or if modes chatter.
#pragma once

#include "formulations/integrators/methods.hpp"
#include "formulations/integrators/rosenbrock.hpp"

namespace freeplay {

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
