// Torque between a joint's two bodies, from a table u of time or angle. It may follow the table
// with a first-order lag, where z is a state of the element:
//
//     lag·ż = u − z,  z(0) = 0,   M = z;     without a lag M = u
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "mechanism/elements/revolute_joint.hpp"
#include "values/forces.hpp"

namespace freeplay {

/// Torque on a revolute joint from a table against time or angle.
struct TorqueDrive {
  /// Argument of the table.
  enum class Against { time, angle };
  /// Pairs (s or rad, N m).
  using Table = std::vector<std::pair<double, double>>;
  static constexpr std::string_view what = "a torque drive";
  static constexpr std::array<std::string_view, 2> chosen_by{"torque", "torque_table"};
  static constexpr auto reports = ForceElement::Kind::drive;
  std::string name;  ///< of the element in the scene
  int joint = -1;    ///< index into Mechanism::joints
  /// argument of the table
  Against against = Against::time;
  /// (t in s or joint angle in rad, torque in N m), increasing; linear between points. Constant
  /// outside for time, repeated every 2π for an angle. One point is a constant torque. A positive
  /// torque turns the second body counterclockwise.
  Table table;
  /// Time constant of the lag (s), > 0; empty: no lag.
  std::optional<double> lag = {};

  static void keys(auto& k, auto& d) {
    k.template joint<RevoluteJoint>(
        {"joint", "", "the revolute joint that is driven (translational: none yet)"}, d.joint);
    k.table(
        {"torque", "N m", "constant torque on the second body, its opposite on the first"},
        {"torque_table", "s or rad, N m", "tabulated torque: [[t or angle, torque], ...], linear between"},
        d.table);
    k.check(!d.table.empty(), "", "needs exactly one of torque and torque_table");
    if (k.when_given("torque_table")) k.choose({"against", "", "torque_table: "}, d.against);
    k.check(d.against == Against::time || span(d.table) <= turn * (1 + 1e-9), "torque_table",
            "against an angle must span at most one turn, spans ", span(d.table), " rad");
    k.take({"lag", "s", "the torque follows with a first-order lag of this time constant, from 0"}, d.lag,
           positive);
  }

  /// rad, a full turn
  static constexpr double turn = 2 * std::numbers::pi;
  /// Length of a table's range (s or rad).
  static double span(const Table& table) {
    return table.empty() ? 0 : table.back().first - table.front().first;
  }
};

inline constexpr auto against_names =
    complete<TorqueDrive::Against>({{TorqueDrive::Against::time, "time", "constant outside"},
                                    {TorqueDrive::Against::angle, "angle", "repeats every 2π"}});
constexpr std::span<const Choice<TorqueDrive::Against>> choices(TorqueDrive::Against) {
  return against_names;
}

}  // namespace freeplay
