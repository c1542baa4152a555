// Dynamics of mechanism/elements/bump_stop.hpp, which states the equations.
#pragma once

#include "dynamics/elements/dynamics.hpp"
#include "mechanism/elements/bump_stop.hpp"
#include "numerics/choice.hpp"

namespace freeplay {

/// Force of a Bump along the limited coordinate, and its energy.
struct BumpForce : Bump {
  template <class T>
  struct Push {
    T force = 0;    ///< on the second body, along the limited coordinate
    T damping = 0;  ///< W, ≤ 0
    friend Push select(const Traced& condition, const Push& a, const Push& b) {
      return {select(condition, a.force, b.force), select(condition, a.damping, b.damping)};
    }
  };
  /// `piece`: interval between two limits to which a step is restricted (dynamics/phase.hpp). It
  /// decides whether the stop acts: the force jumps by damping ẏ at a limit, where rounding puts
  /// `at` on either side.
  template <class T>
  Push<T> push(const T& at, const T& speed, const PieceOf<T>* piece) const {
    const auto one = [&](const T& y, const T& rate, double sign) -> Push<T> {
      const T spring = stiffness * y, f = spring + damping * rate;
      // Beyond the piece the formula continues, also to negative values, without a jump at the
      // limit. Otherwise stages of a long step that find no force there would agree that there is
      // none.
      const T size = choose(
          is_below(y, 0),
          [&] {
            return choose(
                is_below(0, rate), [&] { return f; }, [&] { return spring; });
          },
          [&] {
            return choose(
                is_below(0, f), [&] { return f; }, [&] { return T(0); });
          });
      return {-sign * size, -(size - spring) * rate};
    };
    const T place = piece ? piece->inside() : at;
    const auto below = [&]() -> Push<T> {
      if (!lower) return {};
      return choose(
          is_below(place, *lower), [&] { return one(T(*lower) - at, -speed, -1); }, [] { return Push<T>{}; });
    };
    if (!upper) return below();
    return choose(
        is_below(*upper, place), [&] { return one(at - T(*upper), speed, 1); }, below);
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
    a.ri += a.d;  // on the first body it acts at the second's point
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
