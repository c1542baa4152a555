// Spring and damper between two points: pulls them together with
//
//     F = stiffness (l − free_length) + damping l̇,     U = ½ stiffness (l − free_length)²
//
// along the line through them, l their distance. Where they coincide there is no direction and no force; what passes through
// that place is turned round at once, F a jump, which is found as kinks are. What goes
// beyond constant rates (a cubic term, preload, tables, one way only) is spring_law.hpp's.
#pragma once

#include <array>
#include <cmath>
#include <string>

#include "model/body.hpp"
#include "model/elements/spring_law.hpp"
#include "model/phase.hpp"
#include "values/forces.hpp"

namespace freeplay {

struct SpringDamper {
  static constexpr std::string_view type = "spring-damper", what = "a spring-damper";
  static constexpr auto reports = ForceElement::Kind::force;
  static constexpr auto kinks_of = Phase::Of::distance;
  std::string name;
  std::array<int, 2> between{ground, ground};
  std::array<Vec2, 2> at{Vec2{0, 0}, Vec2{0, 0}};
  double stiffness = 0;    ///< N/m
  double damping = 0;      ///< N s/m
  double free_length = 0;  ///< m
  SpringLaw law = {};      ///< what is not constant of it

  static void keys(auto& k, auto& l) {
    k.between("two bodies, or \"ground\" and a body", l.between);
    k.ends("its two ends", l.at);
    k.pairs({"force_table", "m, N",
             "[[length, pull], ...] in place of stiffness and free_length: linear between, its end "
             "slopes go on"},
            l.law.table);
    const bool rates = k.when(l.law.table.empty(), {"stiffness", "free_length", "cubic", "preload"},
                              "goes without force_table, which gives the force at every length");
    if (rates) k.take({"stiffness", "N/m", "rate, ≥ 0"}, l.stiffness, non_negative);
    k.pairs(
        {"damping_table", "m/s, N", "[[speed of lengthening, pull], ...] in place of damping; has [0, 0]"},
        l.law.damping_table);
    if (k.when(l.law.damping_table.empty(), {"damping"},
               "goes without damping_table, which gives the force at every speed"))
      k.take({"damping", "N s/m", "damping, ≥ 0"}, l.damping, non_negative);
    if (rates) {
      k.take({"free_length", "m", "length without force"}, l.free_length, non_negative);
      k.take({"cubic", "N/m³", "times the cube of the extension: hardens, < 0 softens"}, l.law.cubic,
             any_number);
      k.take({"preload", "N", "pull at free_length"}, l.law.preload, any_number);
    }
    k.choose({"one_way", "", "left out: both ways; "}, l.law.one_way);
    l.law.check(k, "force_table", "damping_table", l.stiffness);
  }

  auto link(auto& b) const { return b.link(between, at); }
  bool does_work() const { return law.damps(damping); }
  bool needs_velocity() const { return law.damps(damping); }
  /// m, lengths where the force has kinks; the least stands for 0, where one that exerts something turns round.
  std::vector<double> kinks() const {
    auto list = law.kinks(stiffness, free_length);
    const double reach = 1e-9 * reversing();
    std::erase_if(list, [&](double length) { return !(length > reach); });
    if (reach > 0) list.insert(list.begin(), reach);
    return list;
  }
  /// m, the length that its force at length 0 acts over; 0: it exerts nothing there.
  double reversing() const {
    const double force = law.elastic(stiffness, free_length, 0.0, 0.0);
    if (force == 0 || !law.acts(force)) return 0;
    if (!law.table.empty()) return std::abs(law.table.back().first);
    return free_length > 0 ? free_length : stiffness > 0 ? std::abs(force) / stiffness : 1;
  }

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
    if (!law.plain()) {
      const auto f = law.force(stiffness, free_length, damping, length, speed, m.piece);
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
    if (!law.plain()) return law.energy(stiffness, free_length, length);
    const double x = length - free_length;
    return 0.5 * stiffness * x * x;
  }
};

}  // namespace freeplay
