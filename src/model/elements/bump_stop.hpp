// One-sided springs and dampers: a bump stop of the travel x = a·(r_j − r_i) along an axis a of the first body, and one of
// the angle θ_j − θ_i. Beyond a limit by y > 0 they push back, and never pull,
//
//     F = max(0, stiffness y + damping ẏ),     U = ½ stiffness y²,     dissipated (F − stiffness y) ẏ ≥ 0
//
// The force acts on both bodies through the second one's point.
#pragma once

#include <array>
#include <optional>
#include <string>

#include "model/body.hpp"
#include "model/kinematics.hpp"
#include "values/forces.hpp"

namespace freeplay {

/// What both kinds share: limits, and the force along what they limit.
struct Bump {
  std::optional<double> lower = {}, upper = {};  ///< m or rad, one of them at least
  double stiffness = 0;                          ///< N/m or N m/rad
  double damping = 0;                            ///< N s/m or N m s/rad

  static void keys(auto& k, auto& b, std::string_view unit, std::string_view rate, std::string_view speed) {
    k.take({"lower", unit, "below it the stop pushes up; left out: no stop there"}, b.lower, any_number);
    k.take({"upper", unit, "above it the stop pushes back; left out: no stop there"}, b.upper, any_number);
    k.check(b.lower || b.upper, "", "needs lower or upper, or both");
    k.check(!(b.lower && b.upper) || *b.lower < *b.upper, "upper", "must be greater than lower");
    k.take({"stiffness", rate, "rate, ≥ 0"}, b.stiffness, non_negative);
    k.take({"damping", speed, "damping, ≥ 0"}, b.damping, non_negative);
  }

  template <class T>
  struct Push {
    T force = 0;    ///< on the second body, along what is limited
    T damping = 0;  ///< W, ≤ 0
  };
  /// `piece`: what lies between two limits, which a step is held to (model/phase.hpp). It decides whether the stop acts:
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

struct BumpStop {
  static constexpr std::string_view type = "bump-stop", what = "a bump stop";
  static constexpr auto reports = ForceElement::Kind::force;
  std::string name;
  std::array<int, 2> between{ground, ground};
  std::array<Vec2, 2> at{Vec2{0, 0}, Vec2{0, 0}};
  Vec2 axis{1, 0};  ///< unit vector in the first body's frame
  Bump bump;        ///< limits in m

  static void keys(auto& k, auto& l) {
    k.between("two bodies, or \"ground\" and a body", l.between);
    k.ends("its two ends", l.at);
    k.axis("direction of the travel in the first body's frame", l.axis);
    Bump::keys(k, l.bump, "m", "N/m", "N s/m");
  }

  auto link(auto& b) const { return b.link(between, at); }
  bool does_work() const { return bump.damping > 0; }
  bool needs_velocity() const { return bump.damping > 0; }

  template <class T>
  void act(const auto& m, const auto& link, const T*, auto& out) const {
    auto a = m.arms(link);
    const auto along = turned(link.i, axis, m.e);
    const T travel = dot(along, a.d);
    a.ri += a.d;  // the first body's point where the second's is
    const auto push = bump.push(travel, T(dot(along, m.relative_velocity(link, a))), m.piece);
    out.pull(link, a, Vec2Of<T>{push.force * along.x(), push.force * along.y()});
    out.power.damping += push.damping;
  }

  double potential(const auto& at_rest, const auto& link) const {
    const Vec2 from = at_rest.point(link.i, link.si);
    return bump.energy(
        dot(at_rest.point(link.i, link.si + axis) - from, at_rest.point(link.j, link.sj) - from));
  }
};

struct TorsionalBumpStop {
  static constexpr std::string_view type = "torsional-bump-stop", what = "a torsional bump stop";
  static constexpr auto reports = ForceElement::Kind::torque;
  std::string name;
  std::array<int, 2> between{ground, ground};
  Bump bump;  ///< limits in rad, of θ_second − θ_first

  static void keys(auto& k, auto& l) {
    k.between("two bodies, or \"ground\" and a body", l.between);
    Bump::keys(k, l.bump, "rad", "N m/rad", "N m s/rad");
  }

  auto link(auto& b) const { return b.free_link(between, {}); }
  bool does_work() const { return bump.damping > 0; }
  bool needs_velocity() const { return bump.damping > 0; }

  template <class T>
  void act(const auto& m, const auto& link, const T*, auto& out) const {
    const auto push = bump.push(T(m.angle(link)), T(m.spin(link)), m.piece);
    out.couple(link, push.force);
    out.power.damping += push.damping;
  }

  double potential(const auto& at_rest, const auto& link) const { return bump.energy(at_rest.angle(link)); }
};

}  // namespace freeplay
