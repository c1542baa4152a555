// Torsional spring and damper: turns its two bodies towards a relative angle φ = θ_j − θ_i with
//
//     M = −stiffness (φ − free_angle) − damping φ̇,     U = ½ stiffness (φ − free_angle)²
#pragma once

#include <array>
#include <string>

#include "model/body.hpp"
#include "values/forces.hpp"

namespace freeplay {

struct TorsionalSpringDamper {
  static constexpr std::string_view type = "torsional-spring-damper", what = "a torsional spring-damper";
  static constexpr auto reports = ForceElement::Kind::torque;
  std::string name;
  std::array<int, 2> between{ground, ground};
  double stiffness = 0;   ///< N m/rad
  double damping = 0;     ///< N m s/rad
  double free_angle = 0;  ///< rad, of θ_second − θ_first

  static void keys(auto& k, auto& l) {
    k.between("two bodies, or \"ground\" and a body", l.between);
    k.take({"stiffness", "N m/rad", "rate, ≥ 0"}, l.stiffness, non_negative);
    k.take({"damping", "N m s/rad", "damping, ≥ 0"}, l.damping, non_negative);
    k.take({"free_angle", "rad", "relative angle without torque"}, l.free_angle);
  }

  auto link(auto& b) const { return b.free_link(between, {}); }
  bool does_work() const { return damping > 0; }
  bool needs_velocity() const { return damping > 0; }

  template <class T>
  void act(const auto& m, const auto& link, const T*, auto& out) const {
    const T speed = m.spin(link);
    const T angle = m.angle(link) - free_angle;
    out.couple(link, T(-(stiffness * angle + damping * speed)));
    out.power.damping -= damping * speed * speed;
  }

  double potential(const auto& at_rest, const auto& link) const {
    const double x = at_rest.angle(link) - free_angle;
    return 0.5 * stiffness * x * x;
  }
};

}  // namespace freeplay
