// Contact laws with hysteresis damping,
//
//     F = F_el(δ) (1 + χ δ̇/v₀),     clamped at zero,
//
// where F_el is an elastic law (law.hpp) and χ(e) the damping factor of a point law
// (laws/NAME.hpp). For a free impact, the coefficient of restitution ê that such a law delivers
// satisfies
//
//     χ (1 + ê) = ln[(1 + χ)/(1 − χ ê)]
//
// for any F_el and mass: divide m δ̇ dδ̇ = −F dδ by the bracket and integrate over the loop, where
// ∮ F_el dδ = 0. Solved for χ at a given ê, this equation is the exact law. Kelvin–Voigt, F = K δ +
// D δ̇, is the one law of a different form.
//
// v₀ is δ̇ at contact onset during the whole first compression, as in the published laws, and
// during the expansion that follows. A contact that closes without approach speed, or that is
// compressed again before it separates, takes v₀ as the greatest w = √(δ̇² + 2U(δ)/m) of that
// compression: the approach speed of a free impact that would reach this state without loss (U = ∫
// F_el dδ, m the effective mass of the contact).
//
// If the surface's restitution depends on the approach speed (src/mechanism/surface.hpp), χ = χ(e(v₀)).
//
// make_contact_force() makes the law of one contact from the scene; ContactForce evaluates it.
#pragma once

#include <optional>

#include "dynamics/evaluation.hpp"
#include "formulations/contact/law.hpp"
#include "mechanism/laws.hpp"
#include "mechanism/options.hpp"

namespace freeplay {

struct Scene;
struct Surface;

/// χ(e(v₀)) of a surface whose restitution depends on the approach speed.
class DampingBySpeed {
 public:
  /// Keeps a reference to `surface`. Throws ModelError where χ is not defined for one of its e.
  DampingBySpeed(ContactLaw law, const Surface& surface);
  double operator()(double v0) const;
  template <int N>
  Dual<N> operator()(const Dual<N>& v0) const {
    return v0.chain((*this)(v0.value), slope(v0.value));
  }

 private:
  double slope(double v0) const;
  ContactLaw law_;
  const Surface* surface_;
  mutable double v0_ = -1, chi_ = 0;  // of the last evaluation: v₀ is mostly constant during a contact
};

/// The law of one contact, ready to evaluate.
struct ContactForce {
  ElasticLaw elastic;
  double chi = 0;                               ///< χ, ≥ 0; with by_speed that of vanishing v₀
  double viscous = 0;                           ///< D of Kelvin–Voigt, N s/m
  std::optional<DampingBySpeed> by_speed = {};  ///< in place of χ

  /// Whether the law is a user-defined function. It defines its whole force (elastic.own_force),
  /// and χ and D are not used.
  bool own() const { return elastic.kind == ElasticLaw::Kind::own; }
  bool dissipates() const { return hysteretic() || viscous > 0 || own(); }
  /// Whether F depends on v₀ through χ.
  bool hysteretic() const { return chi > 0 || by_speed; }
  /// F for δ > 0; `elastic_force` is elastic.force(δ), and v₀ > 0 is a number or depends on the
  /// state.
  template <class T, class V0>
  T force(const T& delta, const T& elastic_force, const T& rate, const V0& v0) const {
    if (own()) [[unlikely]]
      return elastic.own_force(delta, rate, v0);
    const T f = unclamped(elastic_force, rate, v0);
    return f < 0 ? T(0) : f;  // a NaN stays NaN
  }
  template <class T, class V0>
  T unclamped(const T& elastic_force, const T& rate, const V0& v0) const {
    if (by_speed) [[unlikely]]
      return elastic_force * (1 + (*by_speed)(v0) / v0 * rate);
    return elastic_force * (1 + chi / v0 * rate) + viscous * rate;
  }
  /// The speed (m/s) at which a mass m would meet the contact from free flight to reach this depth
  /// and rate without loss: w² = δ̇² + 2U(δ)/m.
  template <class T, class Mass>
  T touch_speed(const T& delta, const T& rate, const Mass& mass) const {
    using std::sqrt;
    return sqrt(rate * rate + 2 / mass * elastic.energy(delta));
  }
};

/// χ of a point law at the requested restitution. Throws ModelError for other laws, and where χ is
/// not defined.
double damping_factor(ContactLaw law, double restitution);
/// ê from χ by the equation above, by a bracketed root search (Boost TOMS 748).
double delivered_restitution(double chi);

/// The point law from which the contact law of a scene takes its χ.
ContactLaw damping_of(const PenaltyOptions& options);

/// The law of one contact from the scene's options. A user-defined law, and one whose restitution depends
/// on the approach speed, keep references to both arguments. Throws ModelError that names a missing key.
ContactForce make_contact_force(const Scene& scene, const ContactFacts& contact);

/// Hertz's K = (4/3) E* √R, with E* = E/(2(1 − ν²)) for equal materials and R = R_i R_j/(R_i − R_j)
/// for a journal inside a bearing.
double hertz_stiffness(double young, double poisson, double radius);

/// κ = k_T/k_N of a surface: its own, or 2(1 − ν)/(2 − ν) of equal elastic
/// materials (Mindlin 1949). Throws ModelError that names a missing key.
double stiffness_ratio(const Surface& surface);

/// Duration (s) of the undamped impact of a mass m (kg) at speed v (m/s): 2.9432… δ_max/v for
/// Hertz, in general 2 ∫ dδ/√(v² − 2U(δ)/m), estimated from the energy balance at the greatest
/// depth.
double elastic_duration(const ElasticLaw& law, double mass, double speed);

}  // namespace freeplay
