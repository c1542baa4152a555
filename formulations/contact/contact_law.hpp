// Contact laws with hysteresis damping,
//
//     F = F_el(δ) (1 + χ δ̇/v₀),     clamped at zero,
//
// where F_el is one of elastic.hpp and χ(e) the damping factor of a point law, contact/NAME.hpp. For a free impact the
// restitution ê that such a law delivers obeys
//
//     χ (1 + ê) = ln[(1 + χ)/(1 − χ ê)]
//
// for any F_el and mass: divide m δ̇ dδ̇ = −F dδ by the bracket and integrate over the loop, where ∮ F_el dδ = 0. Solved
// for χ at a given ê it is the exact law. Kelvin–Voigt, F = K δ + D δ̇, is the one law of another form.
//
// v₀ is δ̇ at first touch through the whole of the first compression, as the laws were published, and its expansion. A contact
// that was laid down, or is pressed or struck once it has been let go, takes the greatest w = √(δ̇² + 2U(δ)/m) of that
// compression instead, the speed of a touch from flight that would have brought it there (U = ∫ F_el dδ, m the mass that
// an impact there meets).
#pragma once

#include "dynamics/evaluation.hpp"
#include "formulations/contact/contact_parts.hpp"
#include "mechanism/laws.hpp"
#include "mechanism/options.hpp"

namespace freeplay {

struct Scene;

/// One contact's law, ready to evaluate.
struct ContactForce {
  ElasticLaw elastic;
  double chi = 0;      ///< χ, ≥ 0
  double viscous = 0;  ///< D of Kelvin–Voigt, N s/m

  /// From outside: force() is its own (elastic.own_force), whatever χ and D.
  bool own() const { return elastic.kind == ElasticLaw::Kind::own; }
  bool dissipates() const { return chi > 0 || viscous > 0 || own(); }
  /// F for δ > 0; `elastic_force` is elastic.force(δ), v₀ > 0 a number or of the state.
  template <class T, class V0>
  T force(const T& delta, const T& elastic_force, const T& rate, const V0& v0) const {
    if (own()) [[unlikely]]
      return elastic.own_force(delta, rate, v0);
    const T f = elastic_force * (1 + chi / v0 * rate) + viscous * rate;
    return f < 0 ? T(0) : f;  // a NaN stays one
  }
  /// The speed (m/s) with which a mass m would come from flight to this depth and rate without loss: w² = δ̇² + 2U(δ)/m.
  template <class T>
  T touch_speed(const T& delta, const T& rate, double mass) const {
    using std::sqrt;
    return sqrt(rate * rate + 2 / mass * elastic.energy(delta));
  }
};

/// χ of a point law at the restitution asked for. Throws ModelError where it has none, and for the other laws.
double damping_factor(ContactLaw law, double restitution);
/// ê from χ by the equation above, by a bracketed root search (Boost TOMS 748).
double delivered_restitution(double chi);
/// ê of a free impact of mass m (kg) under Kelvin–Voigt with the force clamped at zero: the exit is where F = 0.
double kelvin_voigt_restitution(double stiffness, double viscous, double mass);

/// The law of one contact from the scene's options; one from outside refers to both. Throws ModelError about the key that is missing.
ContactForce make_contact_force(const Scene& scene, const ContactFacts& contact);

/// Hertz's K = (4/3) E* √R, E* = E/(2(1 − ν²)) for like materials; R = R_i R_j/(R_i − R_j) of a journal
/// inside a bearing.
double hertz_stiffness(double young, double poisson, double radius);

/// Duration of the undamped impact of a mass m (kg) at speed v (m/s): Hertz's 2.9432… δ_max/v, in general
/// 2 ∫ dδ/√(v² − 2U(δ)/m) estimated from the energy balance at the greatest depth.
double elastic_duration(const ElasticLaw& law, double mass, double speed);

}  // namespace freeplay
