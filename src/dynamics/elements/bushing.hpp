// Dynamics of mechanism/elements/bushing.hpp, which states the equations.
#pragma once

#include "dynamics/elements/dynamics.hpp"
#include "dynamics/elements/spring_force.hpp"
#include "dynamics/phase.hpp"
#include "mechanism/elements/bushing.hpp"

namespace freeplay {

template <>
struct Dynamics<Bushing> : Bushing {
  SpringForce spring{radial};

  static constexpr auto kinks_of = Phase::Of::distance;

  auto link(auto& b) const { return b.link(between, at); }
  bool does_work() const { return needs_velocity(); }
  bool needs_velocity() const { return !damping.is_zero() || turn_damping > 0; }
  /// Distances (m) at which the force has kinks.
  std::vector<double> kinks() const { return spring.kinks(0, 0); }

  template <class T>
  void act(const auto& m, const auto& link, const T*, auto& out) const {
    using std::sqrt;
    auto a = m.arms(link);
    a.ri += a.d;  // on the first body it acts at the second's point
    const Vec2Of<T> along = turned(link.i, axis, m.e), across = perp(along);
    const T x = dot(along, a.d), y = dot(across, a.d);
    T fx = -stiffness.x() * x, fy = -stiffness.y() * y;
    if (!spring.table.empty()) {
      const T length = sqrt(x * x + y * y);
      if (length > 0) {
        const T f = spring.force(0, 0, 0, length, T(0), m.piece).whole / length;
        fx -= f * x;
        fy -= f * y;
      }
    }
    if (!damping.is_zero()) {
      const Vec2Of<T> w = m.relative_velocity(link, a);
      const T u = dot(along, w), v = dot(across, w);
      fx -= damping.x() * u;
      fy -= damping.y() * v;
      out.power.damping -= damping.x() * u * u + damping.y() * v * v;
    }
    out.pull(link, a, Vec2Of<T>{fx * along.x() + fy * across.x(), fx * along.y() + fy * across.y()});
    if (turn_stiffness == 0 && turn_damping == 0) return;
    const T spin = m.spin(link);
    out.couple(link, T(-(turn_stiffness * (m.angle(link) - free_angle) + turn_damping * spin)));
    out.power.damping -= turn_damping * spin * spin;
  }

  double potential(const auto& at_rest, const auto& link) const {
    const Vec2 d = at_rest.point(link.j, link.sj) - at_rest.point(link.i, link.si);
    const Vec2 along = at_rest.point(link.i, axis) - at_rest.point(link.i, {0, 0});
    const double x = dot(along, d), y = dot(perp(along), d), turn = at_rest.angle(link) - free_angle;
    const double sum = stiffness.x() * x * x + stiffness.y() * y * y + turn_stiffness * turn * turn;
    return 0.5 * sum + (spring.table.empty() ? 0 : spring.energy(0, 0, d.norm()));
  }
};

}  // namespace freeplay
