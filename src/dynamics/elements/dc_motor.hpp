// Dynamics of mechanism/elements/dc_motor.hpp, which states the equations.
#pragma once

#include "dynamics/argument.hpp"
#include "dynamics/elements/dynamics.hpp"
#include "dynamics/phase.hpp"
#include "mechanism/elements/dc_motor.hpp"
#include "mechanism/piecewise.hpp"
#include "numerics/choice.hpp"

namespace freeplay {

template <>
struct Dynamics<DcMotor> : DcMotor {
  Piecewise supply = {};  ///< set by prepare()

  void prepare(const auto& mechanism) { supply = voltage.lay(mechanism.curves); }
  auto link(auto& b) const { return b.joint_link(joint); }
  bool does_work() const { return true; }
  bool needs_velocity() const { return true; }
  bool has_state() const { return inductance.has_value(); }
  /// Scale of the current (A).
  double state_scale() const {
    const double most = supply.greatest().value;
    return most > 0 ? most / resistance : 1;
  }
  double next_knot(double t) const { return supply.next_knot(t); }
  std::optional<CurveReader> reader(const Link& link) const {
    return reader_of(name, supply, Argument::time, link);
  }

  template <class T>
  T flow(const auto& m, const auto& link, const T& current) const {
    return (excess<T>(m, link) - resistance * current) / *inductance;
  }
  template <class T>
  void act(const auto& m, const auto& link, const T* current, auto& out) const {
    const T torque = torque_constant * (current ? *current : excess<T>(m, link) / resistance);
    out.couple(link, torque);
    out.power.drive += torque * m.spin(link);
  }

 private:
  /// U − k_e ω
  template <class T>
  T excess(const auto& m, const auto& link) const {
    const T speed = m.spin(link), emf = emf_constant.value_or(torque_constant) * speed;
    if (const auto* s = m.reading.sweep) return supply.mean(m.t - 0.5 * s->h, m.t + 0.5 * s->h) - emf;
    return supply.value(m.t) - emf;
  }
};

}  // namespace freeplay
