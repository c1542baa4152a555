// Loss in the mesh of teeth without backlash, by the efficiency where the first body drives, η₁, and where
// it is driven, η₂; of a worm by Coulomb's μ at the lead angle γ, with ρ = atan μ:
//
//     η₁ = tan γ/tan(γ + ρ),     η₂ = tan(γ − ρ)/tan γ
//
// A worm with η₂ ≤ 0 (γ ≤ ρ) is self-locking. The loss is a friction couple on the first body, bounded by
// the torque M of the mesh without it: c₁ |M| where the first body drives, c₂ |M| where it is driven,
//
//     c₁ = 1/η₁ − 1,     c₂ = 1 − η₂
//
// The law is that of LossyGear in the Modelica Standard Library (C. Pelchen, C. Schweiger, M. Otter,
// Modelica Conference 2002); the worm's: G. Niemann, H. Winter, Maschinenelemente III (1983).
#pragma once

#include <array>
#include <cmath>
#include <numbers>
#include <optional>

#include "mechanism/keys.hpp"

namespace freeplay {

/// Loss of a pair of gears, or of a gear and a rack.
struct MeshLoss {
  std::optional<double> efficiency = {};       ///< η₁, 0 < η₁ ≤ 1
  std::optional<double> back_efficiency = {};  ///< η₂ ≤ 1; empty: η₁
  std::optional<double> lead_angle = {};       ///< rad, γ of a worm, the first body
  std::optional<double> friction = {};         ///< μ of the worm's flanks
  /// rad/s, of the first body, below which the penalty formulation's friction is linear in speed
  std::optional<double> regularisation = {};

  /// Whether there is a loss.
  bool any() const { return efficiency || friction; }
  /// c₁ and c₂
  std::array<double, 2> shares() const {
    if (!friction) return {1 / *efficiency - 1, 1 - back_efficiency.value_or(*efficiency)};
    const double rho = std::atan(*friction), slope = std::tan(*lead_angle);
    return {std::tan(*lead_angle + rho) / slope - 1, 1 - std::tan(*lead_angle - rho) / slope};
  }

  /// Of the efficiency where the first body drives.
  static constexpr Range share{[](double x) { return x > 0 && x <= 1; }, "greater than 0 and at most 1"};
  /// Of that where it is driven back; self-locking from 0 downwards.
  static constexpr Range at_most_one{[](double x) { return x <= 1; }, "1 or less"};
  /// Of the lead angle, rad.
  static constexpr Range lead{[](double x) { return x > 0 && x < std::numbers::pi / 2; },
                              "between 0 and 1.5708 rad, both left out"};

  static void keys(auto& k, auto& l) {
    k.take({"efficiency", "", "of the mesh where the first body drives; if absent: no loss"}, l.efficiency,
           share);
    k.take({"back_efficiency", "",
            "where the first body is driven; 0 or less: self-locking; if absent: efficiency"},
           l.back_efficiency, at_most_one);
    k.take({"lead_angle", "rad", "of a worm, the first body, in place of efficiency; with mesh_friction"},
           l.lead_angle, lead);
    k.take({"mesh_friction", "", "μ of the flanks of a worm; with lead_angle"}, l.friction, non_negative);
    k.take({"regularisation", "rad/s",
            "rotation rate of the first body below which friction of the mesh is linear; required by the "
            "penalty formulation"},
           l.regularisation, positive);
    k.check(!l.back_efficiency || l.efficiency, "back_efficiency", "goes with efficiency, which is missing");
    k.check(l.lead_angle.has_value() == l.friction.has_value(), l.friction ? "mesh_friction" : "lead_angle",
            "lead_angle and mesh_friction go together; one of them is missing");
    k.check(!l.efficiency || !l.friction, "efficiency",
            "follows from lead_angle and mesh_friction; give one or the other");
    k.check(!l.friction || !l.lead_angle || *l.lead_angle + std::atan(*l.friction) < std::numbers::pi / 2,
            "mesh_friction", "is so great that the worm cannot drive");
    k.check(!l.regularisation || l.any(), "regularisation",
            "belongs to efficiency or mesh_friction; both are missing");
  }
  /// Refuses losses of a joint with backlash.
  static void check(auto& k, const auto& joint) {
    k.check(!joint.clearance || !joint.loss.any(), joint.loss.efficiency ? "efficiency" : "mesh_friction",
            "belongs to pairs without backlash; with backlash, sliding of teeth is not modelled");
  }
};

}  // namespace freeplay
