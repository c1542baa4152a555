// Curves of the contact and friction laws: force over penetration in one free impact, delivered
// over requested restitution, and friction over sliding speed.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace freeplay {

struct Scene;

struct ImpactSetting {
  double mass = 1;     ///< kg
  double speed = 0.1;  ///< m/s, approach speed
  /// m/s: friction laws with this regularisation speed (friction_comparison.hpp); empty: with the
  /// keys of the scene
  std::optional<double> regularisation = {};
};

struct LawCurve {
  std::string_view law;  ///< text of the law
  std::vector<std::array<double, 2>> points;
};

struct LawCurves {
  /// first contact of the scene, for which the curves are computed
  std::string contact;
  double restitution = 1;           ///< requested restitution
  std::vector<LawCurve> impacts;    ///< (δ in m, F in N) from contact onset to separation
  std::vector<LawCurve> delivered;  ///< (requested e, delivered ê) of the point laws
  /// (v in m/s, c/μ) of sliding at constant speeds; without laws that stick if all have the same
  /// regularisation speed
  std::vector<LawCurve> friction;
};

/// Curves of all laws for the first contact of the scene. Line contacts are omitted if its joint
/// has no bearing_length. Throws ModelError if the scene has no contact.
LawCurves law_curves(const Scene& scene, const ImpactSetting& setting);

}  // namespace freeplay
