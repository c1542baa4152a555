// Force of a spring and damper with nonconstant rates, as a function of a coordinate s: a distance
// (m, the force pulls together) or a relative angle (rad, the torque turns back). With
// x = s − rest,
//
//     E(s) = preload + stiffness x + cubic x³,  or a table,      D(ṡ) = damping ṡ,  or a table
//     F = E + D,                                                 U = ∫ E ds
//
// Tables are linear between their points and continue with their last slopes. A spring that only
// pulls exerts max(0, E + D) where E > 0, else nothing; one that only pushes exerts min(0, E + D)
// where E < 0. The damper of a cable therefore acts only while the cable is taut. E has a kink
// where its slope or, for a one-sided spring, its sign changes (dynamics/phase.hpp). Between two
// kinks F is one formula. It is evaluated also beyond the ends of that interval, where it may have
// the other sign.
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "mechanism/keys.hpp"

namespace freeplay {

/// Direction in which a one-sided spring acts.
enum class OneWay { pull, push };
inline constexpr auto one_way_names = complete<OneWay>(
    {{OneWay::pull, "pull", "acts against lengthening only, as a cable; for angles, against increase"},
     {OneWay::push, "push", "acts against shortening only; for angles, against decrease"}});
constexpr std::span<const Choice<OneWay>> choices(OneWay) { return one_way_names; }

/// Points (s, E) or (ṡ, D), the first column increasing.
using SpringTable = std::vector<std::pair<double, double>>;

/// Force of a spring and damper with nonconstant rates.
struct SpringLaw {
  std::optional<double> cubic = {};    ///< N/m³ or N m/rad³
  std::optional<double> preload = {};  ///< N or N m, at rest
  /// empty: the spring acts both ways
  std::optional<OneWay> one_way = {};
  SpringTable table = {};          ///< E; empty: constant rate
  SpringTable damping_table = {};  ///< D; empty: constant rate

  /// Whether the law is linear.
  bool plain() const { return !cubic && !preload && !one_way && table.empty() && damping_table.empty(); }

  /// Refuses data that do not describe a spring and damper.
  void check(auto& k, std::string_view table_key, std::string_view damping_key, double stiffness) const {
    k.check(table.size() != 1, table_key, "must have two points or more, has 1");
    k.check(damping_table.size() != 1, damping_key, "must have two points or more, has 1");
    bool resists = true, through_zero = damping_table.empty();
    for (const auto& [speed, force] : damping_table) {
      resists = resists && speed * force >= 0;
      through_zero = through_zero || (speed == 0 && force == 0);
    }
    k.check(through_zero, damping_key, "must have the point [0, 0]: a damper at rest has no force");
    k.check(resists, damping_key, "must dissipate: the force must have the sign of the speed");
    if (!one_way) return;
    k.check(!table.empty() || cubic.value_or(0) >= 0, "cubic",
            "must be 0 or greater where one_way is set, is ", cubic.value_or(0));
    k.check(stiffness > 0 || cubic.value_or(0) > 0 || !table.empty(), "one_way",
            "needs a stiffness, cubic or table that acts one way; there is none");
  }

  /// Whether a one-sided spring acts at this value of E.
  bool acts(double elastic) const {
    return !one_way || (*one_way == OneWay::pull ? elastic > 0 : elastic < 0);
  }
  /// Whether there is damping, by this coefficient or by a table.
  bool damps(double damping) const { return damping > 0 || !damping_table.empty(); }
};

}  // namespace freeplay
