// Dynamics of mechanism/elements/bump_stop.hpp; the equations stand there.
#pragma once

#include "dynamics/elements/dynamics.hpp"
#include "mechanism/elements/bump_stop.hpp"

namespace freeplay {

/// The force of a Bump along what it limits, and its energy.
struct BumpForce : Bump {
  template <class T>
  struct Push {
    T force = 0;    ///< on the second body, along what is limited
    T damping = 0;  ///< W, ≤ 0
  };
  /// `piece`: what lies between two limits, which a step is held to (dynamics/phase.hpp). It decides whether the stop acts:
  /// the force jumps by damping ẏ at a limit, where rounding leaves `at` on either side.
  template <class T>
  Push<T> push(const T& at, const T& speed, const Piece* piece) const {
    const auto one = [&](const T& y, const T& rate, double sign) -> Push<T> {
      const T spring = stiffness * y, f = spring + damping * rate;
      // Beyond the piece the formula goes on, also below zero, and without a jump at the limit either way: stages of a long step
      // that saw no force there would agree that there is none.
      const T size = value_of(y) < 0 ? (rate > T(0) ? f : spring) : f > T(0) ? f : T(0);
      return {-sign * size, -(size - spring) * rate};
    };
    const double place = piece ? piece->inside() : value_of(at);
    if (upper && place > *upper) return one(at - T(*upper), speed, 1);
    if (lower && place < *lower) return one(T(*lower) - at, -speed, -1);
    return {};
  }
  double energy(double at) const {
    const double y = upper && at > *upper ? at - *upper : lower && at < *lower ? *lower - at : 0;
    return 0.5 * stiffness * y * y;
  }
};

template <>
struct Dynamics<BumpStop> : BumpStop {
  BumpForce limit{bump};

  auto link(auto& b) const { return b.link(between, at); }
  bool does_work() const { return bump.damping > 0; }
  bool needs_velocity() const { return bump.damping > 0; }

  template <class T>
  void act(const auto& m, const auto& link, const T*, auto& out) const {
    auto a = m.arms(link);
    const auto along = turned(link.i, axis, m.e);
    const T travel = dot(along, a.d);
    a.ri += a.d;  // the first body's point where the second's is
    const auto push = limit.push(travel, T(dot(along, m.relative_velocity(link, a))), m.piece);
    out.pull(link, a, Vec2Of<T>{push.force * along.x(), push.force * along.y()});
    out.power.damping += push.damping;
  }

  double potential(const auto& at_rest, const auto& link) const {
    const Vec2 from = at_rest.point(link.i, link.si);
    return limit.energy(
        dot(at_rest.point(link.i, link.si + axis) - from, at_rest.point(link.j, link.sj) - from));
  }
};

template <>
struct Dynamics<TorsionalBumpStop> : TorsionalBumpStop {
  BumpForce limit{bump};

  auto link(auto& b) const { return b.free_link(between, {}); }
  bool does_work() const { return bump.damping > 0; }
  bool needs_velocity() const { return bump.damping > 0; }

  template <class T>
  void act(const auto& m, const auto& link, const T*, auto& out) const {
    const auto push = limit.push(T(m.angle(link)), T(m.spin(link)), m.piece);
    out.couple(link, push.force);
    out.power.damping += push.damping;
  }

  double potential(const auto& at_rest, const auto& link) const { return limit.energy(at_rest.angle(link)); }
};

}  // namespace freeplay
