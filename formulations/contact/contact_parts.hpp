// Interface of the contact laws. The file of a contact law specialises Law with its text, formula,
// source and range, and by its kind
//
//   PointLaw         static double chi(double e)      0 ≤ e ≤ 1; e > 0 where positive_restitution
//   LineLaw          static ElasticLaw elastic(const LineContact&)
//   SpringDamperLaw  static ElasticLaw elastic(double stiffness, double clearance)
#pragma once

#include <limits>
#include <numbers>
#include <optional>

#include "formulations/contact/elastic.hpp"
#include "formulations/contact/law.hpp"
#include "mechanism/laws.hpp"
#include "mechanism/options.hpp"

namespace freeplay {

/// χ from ê, 0 < ê ≤ 1, by the first integral of a free impact (see contact_law.hpp).
double exact_damping_factor(double restitution);

/// Defaults of all contact laws.
struct AnyContactLaw {
  static constexpr bool takes_restitution = true, positive_restitution = false;
  static constexpr std::optional<ContactLaw> damping = std::nullopt;
  static constexpr double least_clearance = 0, clearance_end = std::numeric_limits<double>::infinity();
};

/// F = K δ^(3/2) (1 + χ δ̇/v₀) with Hertz's K.
struct PointLaw : AnyContactLaw {
  static constexpr auto kind = ContactKind::point;
};

/// Data from which a line contact derives its stiffness.
struct LineContact {
  double modulus;    ///< E* = E/(2(1 − ν²)), Pa
  double length;     ///< L of the bearing, m
  double clearance;  ///< ΔR, m
  /// π E* L, N/m
  double line() const { return std::numbers::pi * modulus * length; }
};

/// F = F_el(δ) (1 + χ δ̇/v₀) with the χ of a point law.
struct LineLaw : AnyContactLaw {
  static constexpr auto kind = ContactKind::line;
  static constexpr std::optional<ContactLaw> damping = ContactLaw::exact;
};

/// F = F_el(δ) + D δ̇.
struct SpringDamperLaw : AnyContactLaw {
  static constexpr auto kind = ContactKind::spring_damper;
  static constexpr bool takes_restitution = false;
};

}  // namespace freeplay
