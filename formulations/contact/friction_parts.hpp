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
#pragma once

#include <array>
#include <cmath>

#include "formulations/contact/law.hpp"
#include "mechanism/laws.hpp"
#include "mechanism/options.hpp"

namespace freeplay {

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
  /// A tangential spring with slip takes the place of c(v) (shear_spring.hpp).
  static constexpr bool compliant = false;
  static constexpr bool positive_v0 = true, v1_above_v0 = false;
  static std::array<double, 0> kinks(const FrictionParameters&) { return {}; }
};

}  // namespace freeplay
