// What the file of a friction law gives: text, formula, source, range, keys, and
//
//   static std::array<double, N> kinks(const FrictionParameters&)      speeds > 0 at which c has a kink, rising
//   template <class T> static T coefficient(const FrictionParameters&, const T& s, int n)
//
// c as a function of the sliding speed s = |v| ≥ 0 on the n-th branch: the kinks cut the speed axis into zones, and
// within a zone c is the zone's own smooth branch, continued beyond its ends, so that an integrator which stops at the
// ends never steps over a kink. Branch 0 is the middle one, |v| ≤ the first kink; where c has a kink at rest there is
// none, and the branches count from 1. The caller makes c odd in v.
//
// A law with bristles (bristle = true) gives instead
//
//   template <class T> static T coefficient(const FrictionParameters&, const T& v, const T& speed, const T& z)
//   template <class T> static T bristle_rate(const FrictionParameters&, const T& v, const T& speed, const T& z)
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

/// What a friction law is made of; μ kinetic, μ_s static.
struct FrictionParameters {
  double mu = 0, mu_static = 0;
  double v0 = 0, v1 = 0;  ///< m/s
  double decay = 0;       ///< ξ, s/m
  double viscous = 0;     ///< σ₂, s/m
  double sigma0 = 0;      ///< 1/m
  double sigma1 = 0;      ///< s/m
};

/// The defaults of every friction law: smooth, without a state of its own.
struct AnyFrictionLaw {
  static constexpr bool bristle = false, kink_at_rest = false;
  static constexpr bool positive_v0 = true, v1_above_v0 = false;
  static std::array<double, 0> kinks(const FrictionParameters&) { return {}; }
};

}  // namespace freeplay
