// Registration of contact and friction laws. A law is one enumerator (ContactLaw or FrictionLaw in
// src/mechanism/options.hpp) and one file that specialises Law for it, laws/NAME.hpp or
// friction/NAME.hpp. The build lists the files; the tables and every selection of a law are
// generated from the enumerators. An enumerator without a file does not compile, nor does a file
// without an enumerator.
#pragma once

#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <utility>

#include "mechanism/laws.hpp"
#include "mechanism/options.hpp"
#include "mechanism/outside.hpp"
#include "numerics/dual.hpp"
#include "values/enumerators.hpp"

namespace freeplay {

/// The facts and the equation of a law. The interfaces of contact and of friction laws below name the
/// required members.
template <auto law>
struct Law;

/// Calls f with the Law of the enumerator: a chain of comparisons in the order of the enumerators,
/// all inlined.
template <ScopedEnum E, int I = 0, class F>
[[gnu::always_inline]] inline constexpr decltype(auto) visit_law(E law, F&& f) {
  if constexpr (I + 1 == enumerators<E>()) {
    return f(Law<static_cast<E>(I)>{});
  } else {
    if (law == static_cast<E>(I)) return f(Law<static_cast<E>(I)>{});
    return visit_law<E, I + 1>(law, std::forward<F>(f));
  }
}

/// ElasticLaw: elastic part of a contact force, F_el(δ), for a journal inside a bearing. ΔR = c is
/// the radial clearance, E* = E/(2(1 − ν²)) for equal materials, L the length of the bearing.
/// f = F/(π E* L) has the dimension of a length.
///
///   hertz        F = K δ^(3/2),  K = (4/3) E* √(R_i R_j/ΔR)            point contact
///   power        F = K δⁿ
///   linear       F = K δ
///   logarithmic  δ = f [ln(4ΔR/f) + B]
///   liu          F = (π/2) L E* δ √(δ/[2(ΔR + δ)])
///   persson      F = 2E* ΔR L π b²(b² + 1)/[2 − ln(b² + 1) − 2b⁴],  b² = δ/(2ΔR + δ)
///   foundation   F = K L R_b [(ΔR + δ)(α + sin α cos α) − 2ΔR sin α],  cos α = ΔR/(ΔR + δ)
///   own          F(δ, 0, 1) of a user-defined law (mechanism/outside.hpp)
///
/// The file of each contact law, laws/NAME.hpp, names its elastic law and its source.
struct ElasticLaw {
  enum class Kind { hertz, power, linear, logarithmic, liu, persson, foundation, own };
  Kind kind = Kind::hertz;
  /// K, N/m^n; for liu (π/2) L E* (N/m); for logarithmic π E* L and persson 2π E* L (N/m); for foundation
  /// K L R_b ΔR (N)
  double stiffness = 0;
  double exponent = 1.5;            ///< n of power
  double clearance = 0;             ///< ΔR, m
  double offset = 0;                ///< B of logarithmic
  const OwnLaw* outside = nullptr;  ///< function of own
  const char* contact = nullptr;    ///< name of the contact, passed to that function

  /// Whether F = K δⁿ with K = stiffness and n = exponent.
  bool is_power() const;
  /// Greatest δ (m) for which the law gives a force; infinite for most laws.
  double limit() const;
  /// F_el in N for δ ≥ 0 (m); NaN beyond limit().
  double force(double delta) const {
    if (kind == Kind::hertz) return stiffness * delta * std::sqrt(delta);
    return other_force(delta);
  }
  /// dF_el/dδ (N/m) for δ ≥ 0 (m); NaN beyond limit().
  double slope(double delta) const;
  template <int N>
  Dual<N> force(const Dual<N>& delta) const {
    return delta.chain(force(delta.value), slope(delta.value));
  }
  /// Total force of own, with its damping, clamped at zero.
  double own_force(double delta, double rate, double v0) const;
  /// Total force of own with its derivatives by central differences.
  template <class T, class V0>
  T own_force(const T& delta, const T& rate, const V0& v0) const;
  /// ∫ F_el dδ from 0 (J), in closed form where there is one, otherwise by quadrature.
  double energy(double delta) const;
  template <int N>
  Dual<N> energy(const Dual<N>& delta) const {
    return delta.chain(energy(delta.value), force(delta.value));
  }

 private:
  double other_force(double delta) const;
};

template <class T, class V0>
T ElasticLaw::own_force(const T& delta, const T& rate, const V0& v0) const {
  const double d = value_of(delta), r = value_of(rate), v = value_of(v0);
  // Differences of ∛ε times the size of each argument: rounding error and truncation error are then
  // of the same order.
  const auto slope_in = [](double x, double scale, auto f) {
    const double h = 6e-6 * scale;
    return (f(x + h) - f(x - h)) / (2 * h);
  };
  T f = own_force(d, r, v);
  f += slope_in(d, d, [&](double x) { return own_force(x, r, v); }) * (delta - T(d));
  f += slope_in(r, std::abs(r) + v, [&](double x) { return own_force(d, x, v); }) * (rate - T(r));
  f += slope_in(v, v, [&](double x) { return own_force(d, r, x); }) * (T(v0) - T(v));
  return f;
}

// Interface of the contact laws. The file of a contact law specialises Law with its text, formula,
// source and range, and by its kind
//
//   PointLaw         static double chi(double e)      0 ≤ e ≤ 1; e > 0 where positive_restitution
//   LineLaw          static ElasticLaw elastic(const LineContact&)
//   SpringDamperLaw  static ElasticLaw elastic(double stiffness, double clearance)

/// χ from ê, 0 < ê ≤ 1, by the first integral of a free impact (see contact_law.hpp).
double exact_damping_factor(double restitution);

/// Defaults of all contact laws.
struct AnyContactLaw {
  static constexpr bool takes_restitution = true, positive_restitution = false;
  static constexpr std::optional<ContactLaw> damping = std::nullopt;
  static constexpr double least_clearance = 0, clearance_end = std::numeric_limits<double>::infinity();
  static constexpr bool layered = false;
};

/// F = K δ^(3/2) (1 + χ δ̇/v₀) with Hertz's K.
struct PointLaw : AnyContactLaw {
  static constexpr auto kind = ContactKind::point;
};

/// Data from which a line contact derives its stiffness.
struct LineContact {
  double modulus;         ///< E* = E/(2(1 − ν²)), Pa; 0: the law is that of the layer
  double length;          ///< L of the bearing, m
  double clearance;       ///< ΔR, m
  double bearing_radius;  ///< R_b, m
  double layer;           ///< K of the surface's layer, Pa/m; 0: it has none
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

// Interface of the friction laws. The file of a friction law specialises Law with its text,
// formula, source, range, keys, and
//
//   static std::array<double, N> kinks(const FrictionParameters&)      speeds > 0 at which c has
//                                                                      a kink, ascending
//   template <class T> static T coefficient(const FrictionParameters&, const T& s, int n)
//
// coefficient() is c as a function of the sliding speed s = |v| ≥ 0 on the n-th branch. The kinks
// divide the speed axis into zones. Within a zone, c is the zone's smooth branch, extended beyond
// its ends, so that an integrator that stops at the ends never steps over a kink. Branch 0 is the
// middle one, |v| ≤ the first kink. If c has a kink at rest, there is no branch 0 and branches
// count from 1. The caller makes c odd in v.
//
// A law with a bristle (bristle = true) defines instead
//
//   template <class T>
//   static T coefficient(const FrictionParameters&, const T& v, const T& speed, const T& z)
//   template <class T>
//   static T bristle_rate(const FrictionParameters&, const T& v, const T& speed, const T& z)
//   static double steady_bristle(const FrictionParameters&, double v)  z at which ż = 0
//
// with speed = |v| on the branch.

/// Parameters of friction laws; μ kinetic, μ_s static.
struct FrictionParameters {
  double mu = 0, mu_static = 0;
  double v0 = 0, v1 = 0;  ///< m/s
  double decay = 0;       ///< ξ, s/m
  double viscous = 0;     ///< σ₂, s/m
  double sigma0 = 0;      ///< 1/m
  double sigma1 = 0;      ///< s/m
};

/// Defaults of all friction laws: smooth, without internal state.
struct AnyFrictionLaw {
  static constexpr bool bristle = false, kink_at_rest = false;
  /// A tangential spring with slip takes the place of c(v) (friction_law.hpp).
  static constexpr bool compliant = false;
  static constexpr bool positive_v0 = true, v1_above_v0 = false;
  /// The parameter that is Stribeck's speed, with exponent 2; null: the law has none.
  static constexpr double FrictionParameters::*stribeck = nullptr;
  static std::array<double, 0> kinks(const FrictionParameters&) { return {}; }
};

}  // namespace freeplay
