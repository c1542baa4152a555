// Dynamics of mechanism/elements/torsional_spring_damper.hpp, which states the equations.
#pragma once

#include "dynamics/elements/dynamics.hpp"
#include "dynamics/elements/spring_force.hpp"
#include "dynamics/phase.hpp"
#include "mechanism/elements/torsional_spring_damper.hpp"

namespace freeplay {

template <>
struct Dynamics<TorsionalSpringDamper> : TorsionalSpringDamper {
  SpringForce spring{law};

  static constexpr auto kinks_of = Phase::Of::angle;

  auto link(auto& b) const { return b.free_link(between, {}); }
  bool does_work() const { return spring.damps(damping); }
  bool needs_velocity() const { return spring.damps(damping); }
  /// Angles (rad) at which the torque has kinks.
  std::vector<double> kinks() const { return spring.kinks(stiffness, free_angle); }

  template <class T>
  void act(const auto& m, const auto& link, const T*, auto& out) const {
    const T speed = m.spin(link);
    if (!spring.plain()) {
      const auto f = spring.force(stiffness, free_angle, damping, m.angle(link), speed, m.piece);
      out.couple(link, T(-f.whole));
      out.power.damping -= f.damping * speed;
      return;
    }
    const T angle = m.angle(link) - free_angle;
    out.couple(link, T(-(stiffness * angle + damping * speed)));
    out.power.damping -= damping * speed * speed;
  }

  double potential(const auto& at_rest, const auto& link) const {
    if (!spring.plain()) return spring.energy(stiffness, free_angle, at_rest.angle(link));
    const double x = at_rest.angle(link) - free_angle;
    return 0.5 * stiffness * x * x;
  }
};

}  // namespace freeplay
