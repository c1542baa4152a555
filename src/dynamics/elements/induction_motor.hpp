// Dynamics of mechanism/elements/induction_motor.hpp, which states the equations.
#pragma once

#include "dynamics/elements/dynamics.hpp"
#include "mechanism/elements/induction_motor.hpp"

namespace freeplay {

template <>
struct Dynamics<InductionMotor> : InductionMotor {
  auto link(auto& b) const { return b.joint_link(joint); }
  bool does_work() const { return true; }
  bool needs_velocity() const { return true; }

  template <class T>
  void act(const auto& m, const auto& link, const T*, auto& out) const {
    const T speed = m.spin(link), slip = 1.0 - speed / synchronous_speed;
    const double sense = synchronous_speed > 0 ? 2 : -2;
    const T torque =
        sense * breakdown_torque * breakdown_slip * slip / (slip * slip + breakdown_slip * breakdown_slip);
    out.couple(link, torque);
    out.power.drive += torque * speed;
  }
};

}  // namespace freeplay
