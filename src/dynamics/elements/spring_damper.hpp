// Dynamics of mechanism/elements/spring_damper.hpp, which states the equations.
#pragma once

#include "dynamics/elements/dynamics.hpp"
#include "dynamics/elements/spring_force.hpp"
#include "dynamics/phase.hpp"
#include "mechanism/elements/spring_damper.hpp"

namespace freeplay {

template <>
struct Dynamics<SpringDamper> : SpringDamper {
  SpringForce spring{law};

  static constexpr auto kinks_of = Phase::Of::distance;

  auto link(auto& b) const { return b.link(between, at); }
  bool does_work() const { return spring.damps(damping); }
  bool needs_velocity() const { return spring.damps(damping); }
  /// Lengths (m) at which the force has kinks. The least one represents length 0, where the
  /// direction of a nonzero force reverses.
  std::vector<double> kinks() const {
    auto list = spring.kinks(stiffness, free_length);
    const double reach = 1e-9 * reversing();
    std::erase_if(list, [&](double length) { return !(length > reach); });
    if (reach > 0) list.insert(list.begin(), reach);
    return list;
  }
  /// Length scale (m) of the force at length 0; 0 if it exerts no force there.
  double reversing() const {
    const double force = spring.elastic(stiffness, free_length, 0.0, 0.0);
    if (force == 0 || !spring.acts(force)) return 0;
    if (!spring.table.empty()) return std::abs(spring.table.back().first);
    return free_length > 0 ? free_length : stiffness > 0 ? std::abs(force) / stiffness : 1;
  }

  template <class T>
  void act(const auto& m, const auto& link, const T*, auto& out) const {
    using std::sqrt;
    const auto a = m.arms(link);
    const T length = sqrt(dot(a.d, a.d));
    // The direction is undefined. A spring without free length needs none and keeps its derivative.
    if (!(length > 0)) {
      if (free_length == 0) out.pull(link, a, Vec2Of<T>{-stiffness * a.d.x(), -stiffness * a.d.y()});
      return;
    }
    const Vec2Of<T> along{a.d.x() / length, a.d.y() / length};
    const T speed = dot(along, m.relative_velocity(link, a));
    if (!spring.plain()) {
      const auto f = spring.force(stiffness, free_length, damping, length, speed, m.piece);
      out.pull(link, a, Vec2Of<T>{-f.whole * along.x(), -f.whole * along.y()});
      out.power.damping -= f.damping * speed;
      return;
    }
    const T force = stiffness * (length - free_length) + damping * speed;
    out.pull(link, a, Vec2Of<T>{-force * along.x(), -force * along.y()});
    out.power.damping -= damping * speed * speed;
  }

  double potential(const auto& at_rest, const auto& link) const {
    const double length = (at_rest.point(link.j, link.sj) - at_rest.point(link.i, link.si)).norm();
    if (!spring.plain()) return spring.energy(stiffness, free_length, length);
    const double x = length - free_length;
    return 0.5 * stiffness * x * x;
  }
};

}  // namespace freeplay
