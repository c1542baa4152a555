// Torque between a joint's two bodies, from a table against time or angle; it may follow the table's u with a
// first-order lag, a state z of the element:
//
//     lag·ż = u − z from z = 0,     M = z;     without a lag M = u
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "model/elements/revolute_joint.hpp"
#include "values/forces.hpp"

namespace freeplay {

struct TorqueDrive {
  enum class Against { time, angle };
  using Table = std::vector<std::pair<double, double>>;
  static constexpr std::string_view what = "a torque drive";
  static constexpr std::array<std::string_view, 2> chosen_by{"torque", "torque_table"};
  static constexpr auto reports = ForceElement::Kind::drive;
  std::string name;
  int joint = -1;
  Against against = Against::time;
  /// (t in s or joint angle in rad, torque in N m), increasing; linear between, constant outside in time,
  /// repeated every 2π in angle. One point: a constant torque. Positive turns the second body counter-clockwise.
  Table table;
  /// s, > 0: the torque z follows the table's u with a first-order lag from 0, lag·ż = u − z. Absent: z = u.
  std::optional<double> lag = {};

  static void keys(auto& k, auto& d) {
    k.template joint<RevoluteJoint>(
        {"joint", "", "the revolute joint that is driven (translational: none yet)"}, d.joint);
    k.table(
        {"torque", "N m", "constant torque on the second body, its opposite on the first"},
        {"torque_table", "s or rad, N m", "tabulated torque: [[t or angle, torque], ...], linear between"},
        d.table);
    if (k.when_given("torque_table")) k.choose({"against", "", "torque_table: "}, d.against);
    k.check(d.against == Against::time || span(d.table) <= turn * (1 + 1e-9), "torque_table",
            "against an angle must span at most one turn, spans ", span(d.table), " rad");
    k.take({"lag", "s", "the torque follows with a first-order lag of this time constant, from 0"}, d.lag,
           positive);
  }

  auto link(auto& b) const { return b.joint_link(joint); }
  bool does_work() const { return true; }
  bool has_state() const { return lag.has_value(); }
  /// What errors of the state are measured by (N m).
  double state_scale() const {
    double greatest = 0;
    for (const auto& point : table) greatest = std::max(greatest, std::abs(point.second));
    return greatest > 0 ? greatest : 1;
  }
  template <class T>
  T flow(const auto& m, const auto& link, const T& z) const {
    return (demand<T>(m, link) - z) / *lag;
  }
  /// `z` is nullptr without a state.
  template <class T>
  void act(const auto& m, const auto& link, const T* z, auto& out) const {
    const T torque = z ? *z : demand<T>(m, link);
    out.couple(link, torque);
    out.power.drive += torque * m.spin(link);
  }
  /// The first knot against time after t (s); infinite when there is none.
  double next_knot(double t) const {
    if (against == Against::time && table.size() > 1)
      for (const auto& knot : table)
        if (knot.first > t) return knot.first;
    return INFINITY;
  }

 private:
  static constexpr double turn = 2 * std::numbers::pi;
  static double span(const Table& table) {
    return table.empty() ? 0 : table.back().first - table.front().first;
  }

  /// The table's torque, before any lag.
  template <class T>
  T demand(const auto& m, const auto& link) const {
    if (table.size() == 1) return table[0].second;
    if (against == Against::time) return interpolate(m.t);
    return interpolate_periodic(T(m.angle(link)));
  }
  template <class T>
  T interpolate(const T& x) const {
    if (x <= table.front().first) return table.front().second;
    if (x >= table.back().first) return table.back().second;
    const auto hi = std::ranges::upper_bound(table, value_of(x), {}, &std::pair<double, double>::first);
    const auto lo = hi - 1;
    return lo->second + (hi->second - lo->second) / (hi->first - lo->first) * (x - lo->first);
  }
  /// One turn of a table against an angle, closed from its last point to its first.
  template <class T>
  T interpolate_periodic(const T& angle) const {
    const double first = table.front().first, last = table.back().first;
    const T x = angle - turn * std::floor((value_of(angle) - first) / turn);
    if (x <= last) return interpolate(x);
    return table.back().second +
           (table.front().second - table.back().second) / (first + turn - last) * (x - last);
  }
};

inline constexpr auto against_names =
    complete<TorqueDrive::Against>({{TorqueDrive::Against::time, "time", "constant outside"},
                                    {TorqueDrive::Against::angle, "angle", "repeats every 2π"}});
constexpr std::span<const Choice<TorqueDrive::Against>> choices(TorqueDrive::Against) {
  return against_names;
}

}  // namespace freeplay
