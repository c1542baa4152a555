// Spring and damper between two points: pulls them together with
//
//     F = stiffness (l − free_length) + damping l̇,     U = ½ stiffness (l − free_length)²
//
// along the line through them, l their distance. Where they coincide there is no direction and no force.
#pragma once

#include <array>
#include <cmath>
#include <string>

#include "model/body.hpp"
#include "values/forces.hpp"

namespace freeplay {

struct SpringDamper {
  static constexpr std::string_view type = "spring-damper", what = "a spring-damper";
  static constexpr auto reports = ForceElement::Kind::force;
  std::string name;
  std::array<int, 2> between{ground, ground};
  std::array<Vec2, 2> at{Vec2{0, 0}, Vec2{0, 0}};
  double stiffness = 0;    ///< N/m
  double damping = 0;      ///< N s/m
  double free_length = 0;  ///< m

  static void keys(auto& k, auto& l) {
    k.between("two bodies, or \"ground\" and a body", l.between);
    k.ends("its two ends", l.at);
    k.take({"stiffness", "N/m", "rate, ≥ 0"}, l.stiffness, non_negative);
    k.take({"damping", "N s/m", "damping, ≥ 0"}, l.damping, non_negative);
    k.take({"free_length", "m", "length without force"}, l.free_length, non_negative);
  }

  auto link(auto& b) const { return b.link(between, at); }
  bool does_work() const { return damping > 0; }
  bool needs_velocity() const { return damping > 0; }

  template <class T>
  void act(const auto& m, const auto& link, const T*, auto& out) const {
    using std::sqrt;
    const auto a = m.arms(link);
    const T length = sqrt(dot(a.d, a.d));
    if (!(length > 0)) {  // no direction; a spring without free length needs none, and its derivative stays
      if (free_length == 0) out.pull(link, a, Vec2Of<T>{-stiffness * a.d.x(), -stiffness * a.d.y()});
      return;
    }
    const Vec2Of<T> along{a.d.x() / length, a.d.y() / length};
    const T speed = dot(along, m.relative_velocity(link, a));
    const T force = stiffness * (length - free_length) + damping * speed;
    out.pull(link, a, Vec2Of<T>{-force * along.x(), -force * along.y()});
    out.power.damping -= damping * speed * speed;
  }

  double potential(const auto& at_rest, const auto& link) const {
    const double x = (at_rest.point(link.j, link.sj) - at_rest.point(link.i, link.si)).norm() - free_length;
    return 0.5 * stiffness * x * x;
  }
};

}  // namespace freeplay
