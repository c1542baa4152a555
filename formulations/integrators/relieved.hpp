// An explicit method with an implicit one in reserve. A contact whose regularised friction is steep holds an explicit
// method to steps of its own decay time, thousands to a contact, however smooth the motion; methods of high order
// find no step there at all. When the explicit method fails, or when after many steps in one mode an implicit step
// of twenty times their length passes the same control of errors, the implicit method goes on until the mode changes.
// Where neither happens no digit is touched. A method of a fixed step is relieved only where it fails, or modes chatter.
#pragma once

#include "formulations/integrators/methods.hpp"
#include "formulations/integrators/rosenbrock.hpp"

namespace freeplay {

template <class Method>
class Relieved : public Method {
 public:
  /// `first_probe`: steps in one mode before an implicit one is tried; 0: the explicit method stays alone.
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
  /// The next step is at most this long.
  void limit_step(double h) {
    limit_ = h;
    Method::limit_step(h);
  }
  /// The right-hand side has another form from here on.
  void new_mode() {
    if (stiff_) Method::limit_step(this->t - this->t_old);  // its past is of before
    forget();
  }
  /// The implicit method goes on from here: modes chatter, because no step of the explicit one is stable in them.
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
      if (Method::fixed_step || !affordable_) return false;  // what diverged is shown as what it is
      this->unshift();
      if (!finite(this->x) || !finite(this->dxdt)) {
        this->shift();
        return false;
      }
      relieve();
      implicit_.limit(limit_);  // nothing is known yet of what has just begun
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
  void remember(M& m) {
    Method::remember(m);
    m(stiff_, by_implicit_, steps_, counted_, probe_at_, since_, reliefs_, limit_);
    if constexpr (M::reading) {
      affordable_ = first_probe_ > 0 && this->x.size() <= most_unknowns;
      if (affordable_) implicit_.make_room(this->x.size());
    }
    implicit_.remember(m);
  }

 private:
  static constexpr double stiff_steps = 20;
  /// Dense solves of more cost more than an explicit method's short steps.
  static constexpr std::size_t most_unknowns = 400;

  /// Before the first step, so that none allocates.
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
  bool by_implicit_ = false;  // the last step was: its mode may have ended since
  long first_probe_;
  long steps_ = 0, counted_ = 0, probe_at_ = first_probe_;  // in this mode
  double limit_ = INFINITY;                                 // s, asked of the next step
  double since_ = 0;                                        // s, of the last probe or the mode's beginning
  long reliefs_ = 0;
};

}  // namespace freeplay
