// What the laws look like: force over penetration in one free impact, delivered over requested restitution, friction
// over sliding speed.
#pragma once

#include <array>
#include <string>
#include <string_view>
#include <vector>

namespace freeplay {

struct Scene;

struct ImpactSetting {
  double mass = 1;     ///< kg
  double speed = 0.1;  ///< m/s, of approach
};

struct LawCurve {
  std::string_view law;  ///< its text
  std::vector<std::array<double, 2>> points;
};

struct LawCurves {
  std::string contact;              ///< the scene's first, which the laws are drawn for
  double restitution = 1;           ///< asked for
  std::vector<LawCurve> impacts;    ///< (δ in m, F in N) from first touch until the contact opens
  std::vector<LawCurve> delivered;  ///< (e asked for, ê) of the point laws
  std::vector<LawCurve> friction;   ///< (v in m/s, c over μ) of sliding at constant speeds
};

/// Curves of all laws for the scene's first contact. Line contacts are left out when its joint has no bearing_length.
/// Throws ModelError when the scene has no contact.
LawCurves law_curves(const Scene& scene, const ImpactSetting& setting);

}  // namespace freeplay
