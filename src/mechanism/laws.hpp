// Facts of the contact and friction laws of the penalty formulation, one row a law. The reader,
// help, documentation and error messages are made from them. Each row is in its law's own file,
// formulations/contact/laws/NAME.hpp or formulations/contact/friction/NAME.hpp. The tables are put
// together there, so that this header needs only the standard library.
#pragma once

#include <limits>
#include <optional>
#include <span>
#include <string_view>

namespace freeplay {

enum class ContactLaw;   // options.hpp
enum class FrictionLaw;  // options.hpp

/// Kind of the elastic part of a contact force.
enum class ContactKind {
  point,  ///< Hertz's F_el = K δ^(3/2) with the law's own damping factor χ(e)
  line,   ///< the law's own F_el over the bearing's length; χ from a point law
  /// F = K δ + D δ̇ with K and D from the scene, so its restitution depends on the mass
  spring_damper
};

/// Facts of a contact law.
struct ContactLawFacts {
  /// the law
  ContactLaw law;
  std::string_view text;  ///< its name in a scene
  /// formula, publication and range of validity, as text
  std::string_view formula, source, range;
  /// kind of contact
  ContactKind kind;
  bool takes_restitution;     ///< its damping follows from the surface's restitution
  bool positive_restitution;  ///< restitution must be > 0: χ is infinite at 0
  /// Line laws: the point law whose χ is used unless penalty.damping names another.
  std::optional<ContactLaw> damping;
  /// m; the law is published for least_clearance ≤ c < clearance_end.
  double least_clearance = 0;
  /// m, end of the published range
  double clearance_end = std::numeric_limits<double>::infinity();
  /// Line laws: the stiffness is that of the surface's layer, not of Young's modulus.
  bool layered = false;
};

/// All contact laws, in the order of their enumerators.
std::span<const ContactLawFacts> contact_laws();
/// The facts of a contact law.
const ContactLawFacts& facts_of(ContactLaw law);

/// Facts of a friction law.
struct FrictionLawFacts {
  /// the law
  FrictionLaw law;
  std::string_view text;  ///< its name in a scene
  /// c(v) = |F_T|/F_N for v ≥ 0, with the symbols of docs/theory/friction.md
  std::string_view formula;
  /// publication and range of validity, as text
  std::string_view source, range;
  std::string_view keys;  ///< keys of [penalty] that it reads, separated by ", "
  bool bristle;           ///< has a bristle deflection z (m) as a state
  bool compliant;         ///< is a tangential spring with slip; reads κ of the surface
  bool positive_v0;       ///< requires friction_v0 > 0, else ≥ 0
  bool v1_above_v0;       ///< requires friction_v1 > friction_v0
  bool stribeck;          ///< has Stribeck's speed with exponent 2: takes the static value of surfaces

  /// Whether the law reads a key of [penalty].
  constexpr bool reads(std::string_view key) const {
    for (auto rest = keys; !rest.empty();) {
      const auto end = rest.find(", ");
      if (rest.substr(0, end) == key) return true;
      rest.remove_prefix(end == rest.npos ? rest.size() : end + 2);
    }
    return false;
  }
};

/// All friction laws, in the order of their enumerators.
std::span<const FrictionLawFacts> friction_laws();
/// The facts of a friction law.
const FrictionLawFacts& facts_of(FrictionLaw law);

}  // namespace freeplay
