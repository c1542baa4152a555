// The implicit method of the penalty formulation, for stiff contacts and strong damping: numerics/rosenbrock4
// with the exact Jacobian of PenaltyDynamics::jacobian.
#pragma once

#include "formulations/integrators/methods.hpp"
#include "numerics/rosenbrock4.hpp"

namespace freeplay {

class Rosenbrock : public MethodState {
 public:
  static constexpr bool may_creep = false;
  Rosenbrock(ErrorNorm norm, double first_step)
      : stepper_(0), norm_(std::move(norm)), first_step_(first_step), dt_(first_step) {}

  template <class F>
  void start(F& f, double at, const Vector& state) {
    if (x.size() != state.size()) make_room(state.size());
    begin(at, state);
    f(x, dxdt, t);
  }
  void limit_step(double h) { dt_ = std::min(dt_, h); }

  template <class F>
  bool step(F& f, double t_end) {
    shift();
    linearised_ = false;
    const double wish = dt_;
    for (;;) {
      const bool cut = t_old + dt_ >= t_end;
      const double h = cut ? t_end - t_old : dt_;
      make(f, h);
      const double ratio = norm_.error(*this, x, dxdt, error_, h);
      // The error estimate is of third order: it goes with h⁴.
      const double factor = std::clamp(0.9 * std::pow(std::max(ratio, 1e-10), -0.25), 0.2, 5.0);
      dt_ = h * factor;
      if (ratio <= 1) {
        t = cut ? t_end : t_old + h;
        if (cut) dt_ = std::max(dt_, wish);
        break;
      }
      ++rejected;
      if (vanishing(dt_, first_step_)) return false;
    }
    f(x, dxdt, t);
    return true;
  }
  template <class F>
  void land(F& f, double to) {
    make(f, to - t_old);
    t = to;
    f(x, dxdt, t);
  }
  void interpolate(double at, Vector& out) const { hermite(at, out); }
  /// The Jacobian is of one step only.
  template <class M>
  void remember(M& m) {
    m.part("rosenbrock4");
    MethodState::remember(m);
    m(dt_);
    if constexpr (M::reading) {
      make_room(x.size());
      linearised_ = false;
    }
  }

 private:
  void make_room(std::size_t n) {
    stepper_ = Rosenbrock4(static_cast<int>(n));
    error_.resize(n);
    J_.resize(n * n);
    dfdt_.resize(n);
  }
  /// One step of length h from the old state, whose Jacobian is taken once.
  template <class F>
  void make(F& f, double h) {
    struct Context {
      F& f;
      Rosenbrock& self;
    } context{f, *this};
    Rosenbrock4::Problem problem;
    problem.context = &context;
    problem.side = [](void* c, const double* y, double* dydt, double at) {
      auto& [side, self] = *static_cast<Context*>(c);
      std::copy(y, y + self.x.size(), self.x.begin());
      side(self.x, self.dxdt, at);
      std::copy(self.dxdt.begin(), self.dxdt.end(), dydt);
    };
    problem.jacobian = [](void* c, const double*, double at, double* J, double* dfdt) {
      auto& [side, self] = *static_cast<Context*>(c);
      if (!self.linearised_) side.jacobian(self.x_old, at, self.J_.data(), self.dfdt_.data());
      self.linearised_ = true;
      std::copy(self.J_.begin(), self.J_.end(), J);
      std::copy(self.dfdt_.begin(), self.dfdt_.end(), dfdt);
    };
    stepper_.step(problem, x_old.data(), t_old, h, x.data(), error_.data());
  }

  Rosenbrock4 stepper_;
  ErrorNorm norm_;
  double first_step_, dt_;
  bool linearised_ = false;  // J_ belongs to x_old
  Vector error_, J_, dfdt_;
};

}  // namespace freeplay
