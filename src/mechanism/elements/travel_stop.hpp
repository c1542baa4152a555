// End stops of a translational joint or of a pin in a slot: the travel x = a·(r_j − r_i) stays
// between two limits. Each limit is a contact with a wall across the axis (dynamics/pairs.hpp),
//
//     g = x − lower,     g = upper − x
#pragma once

#include <algorithm>
#include <array>
#include <optional>
#include <string>
#include <utility>
#include <variant>

#include "mechanism/elements/slot_joint.hpp"
#include "mechanism/elements/translational_joint.hpp"
#include "mechanism/surface.hpp"

namespace freeplay {

/// Common facts of the end stops of all kinds of joint.
struct StopFacts {
  std::optional<double> lower = {}, upper = {};  ///< m or rad, at least one of them
  /// N/m, > 0, at the stop; empty: that of Hertz's contact
  std::optional<double> stiffness = {};
  std::optional<double> curvature_radius = {};  ///< m, > 0, at the stop's contact
  int surface = -1;                             ///< index into Mechanism::surfaces

  /// Returns the surface if k is the reader.
  static const Surface* keys(auto& k, auto& s, std::string_view unit) {
    k.take({"lower", unit, "least travel or angle; if absent: no stop there"}, s.lower, any_number);
    k.take({"upper", unit, "greatest travel or angle; if absent: no stop there"}, s.upper, any_number);
    k.check(s.lower || s.upper, "", "needs lower or upper, or both");
    k.check(!(s.lower && s.upper) || *s.lower < *s.upper, "upper", "must be greater than lower");
    k.take({"stiffness", "N/m", "of the stop's contact, for penalty contacts"}, s.stiffness, positive);
    k.take(
        {"curvature_radius", "m", "at the stop's contact: Hertz's stiffness follows from it and the surface"},
        s.curvature_radius, positive);
    k.check(!(s.stiffness && s.curvature_radius), "curvature_radius",
            "computes the stiffness, which is given as well; remove one of them");
    return k.surface({"surface", "", "the surface of its contacts"}, s.surface);
  }
  /// Facts of the contact at one end. `size` (m): length that scales penetrations.
  auto contact(auto& b, const std::string& name, const std::array<int, 2>& between, bool top,
               double size) const {
    auto facts = b.facts(name + (top ? ".upper" : ".lower"), between, surface);
    facts.stiffness = stiffness;
    facts.radius = curvature_radius.value_or(0);
    facts.arm = size;
    facts.clearance = size > 0 ? 1e-3 * size : 1e-3;  // scale for tolerances
    return facts;
  }
};

/// End stops of a translational joint or of a slot.
struct TravelStop {
  static constexpr std::string_view type = "travel-stop", what = "a travel stop";
  std::string name;  ///< of the element in the scene
  int joint = -1;    ///< index into Mechanism::joints
  StopFacts stop;    ///< limits in m

  static void keys(auto& k, auto& c) {
    k.template joint_of<TranslationalJoint, SlotJoint>(
        {"joint", "", "whose travel along its axis is limited: a translational joint or a slot"}, c.joint);
    StopFacts::keys(k, c.stop, "m");
  }
};

}  // namespace freeplay
