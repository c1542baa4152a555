// Curves of the contact and friction laws: force over penetration in one free impact, delivered
// over requested restitution, and friction over sliding speed.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "mechanism/laws.hpp"

namespace freeplay {

struct PenaltyOptions;
struct Scene;

// Friction laws at the same regularisation speed, for comparison. The keys friction_v0 and
// friction_v1 have another meaning in each law, so that equal keys do not give equally steep laws.
// Here the regularisation speed v_r is the sliding speed at which a law first reaches 95 % of the
// kinetic friction,
//
//     c(v_r) = 0.95 μ,
//
// the value of Threlfall's law at its v₀. Laws that stick by a spring have no such speed.

/// Share of the kinetic friction at the regularisation speed.
inline constexpr double regularised_share = 0.95;

/// The options with the speed keys of a law that has the regularisation speed v_r (m/s): friction_v1
/// with friction_v0 = 0 for Ambrósio's law, else friction_v0. Empty for laws that stick, and if the
/// law does not reach that friction (μ_s > μ does not matter).
std::optional<PenaltyOptions> regularised(const FrictionLawFacts& law, const PenaltyOptions& options,
                                          double speed);

/// The regularisation speed (m/s) of a law with these options; empty as above.
std::optional<double> regularisation_speed(const FrictionLawFacts& law, const PenaltyOptions& options);

/// The least speed (m/s) at which a law resists `share` of the kinetic friction in steady sliding: a
/// contact under such a load creeps at it.
double creep_speed(const FrictionLawFacts& law, const PenaltyOptions& options, double share);

struct ImpactSetting {
  double mass = 1;     ///< kg
  double speed = 0.1;  ///< m/s, approach speed
  /// m/s: friction laws with this regularisation speed (regularised()); empty: with the
  /// keys of the scene
  std::optional<double> regularisation = {};
};

struct LawCurve {
  std::string_view law;  ///< text of the law
  std::vector<std::array<double, 2>> points;
};

/// Results of one free impact.
struct LawImpact {
  std::string_view law;    ///< text of the law
  double force = 0;        ///< N, greatest
  double depth = 0;        ///< m, greatest
  double duration = 0;     ///< s
  double restitution = 0;  ///< delivered
  bool outside = false;    ///< clearance or depth outside the range of the law
};

/// Impacts in contacts with the same facts.
struct ContactImpacts {
  std::vector<std::string> contacts = {};  ///< their names, in the order of the scene
  double restitution = 1;                  ///< requested restitution
  std::vector<LawCurve> impacts = {};      ///< (δ in m, F in N) from contact onset to separation
  std::vector<LawImpact> results = {};     ///< of these impacts
};

struct LawCurves {
  std::vector<ContactImpacts> groups;  ///< of all contacts, those with the same facts once
  std::vector<LawCurve> delivered;     ///< (requested e, delivered ê) of the point laws
  /// (v in m/s, c/μ) of sliding at constant speeds; without laws that stick if all have the same
  /// regularisation speed
  std::vector<LawCurve> friction;
};

/// Curves of all laws for the contacts of the scene. Line contacts are omitted if a joint has no
/// bearing_length, the elastic foundation if a surface has no layer, Kelvin–Voigt's law if the scene states
/// no stiffness or damping of it. Throws ModelError if the scene has no contact, or a surface without what a
/// law needs.
LawCurves law_curves(const Scene& scene, const ImpactSetting& setting);

}  // namespace freeplay
