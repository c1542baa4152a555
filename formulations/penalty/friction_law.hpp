// Regularised friction, F_T = −F_N c(v_T), as a function c of the sliding speed v (odd in v), μ kinetic, μ_s
// static:
//
//   Ambrósio 2003       0 below v₀, μ(|v| − v₀)/(v₁ − v₀) between, μ above v₁
//   Threlfall 1978      μ(1 − exp(−3|v|/v₀)) up to v₀, then its value there, 0.95 μ
//   Bengisu–Akay 1994   μ_s[1 − (|v|/v₀ − 1)²] up to v₀, then μ + (μ_s − μ) exp[−ξ(|v| − v₀)]
//   Brown–McPhee 2016   μ tanh(4x) + (μ_s − μ) x/(x²/4 + ¾)² + σ₂ v,  x = v/v₀
//   LuGre 1995          ż = v − |v| z/g,  g = [μ + (μ_s − μ) e^(−(v/v₀)²)]/σ₀,  c = σ₀ z + σ₁ ż + σ₂ v
//
// LuGre's bristle deflection z (m) is a state of its own (Canudas de Wit et al., IEEE Trans. Autom. Control
// 40, 419). Where c has a kink the speed axis is cut into zones; within a zone c is the zone's own smooth
// branch, continued beyond its ends, so that an integrator which stops at the ends never steps over a kink.
#pragma once

#include <cmath>
#include <limits>
#include <type_traits>

#include "model/scene.hpp"

namespace freeplay {

struct FrictionForce {
  FrictionLaw law = FrictionLaw::ambrosio;
  double mu = 0, mu_static = 0;
  double v0 = 0, v1 = 0;  ///< m/s
  double decay = 0;       ///< ξ, s/m
  double viscous = 0;     ///< σ₂, s/m
  double sigma0 = 0;      ///< 1/m
  double sigma1 = 0;      ///< s/m

  bool has_state() const { return law == FrictionLaw::lugre; }

  /// Zone of a speed: 0 in the middle where there is one, its sign that of v.
  int zone(double v) const {
    const double s = std::abs(v);
    const int side = v < 0 ? -1 : 1;
    switch (law) {
      case FrictionLaw::ambrosio:
        return s <= v0 ? 0 : s < v1 ? side : 2 * side;
      case FrictionLaw::threlfall:
      case FrictionLaw::bengisu_akay:
        return s < v0 ? side : 2 * side;
      case FrictionLaw::lugre:
        return side;
      default:
        return 0;
    }
  }
  struct Ends {
    double low, high;
  };
  /// Ends of a zone on the speed axis (m/s).
  Ends ends(int zone) const {
    constexpr double far = std::numeric_limits<double>::infinity();
    const auto mirrored = [&](double a, double b) { return zone < 0 ? Ends{-b, -a} : Ends{a, b}; };
    const int n = zone < 0 ? -zone : zone;
    switch (law) {
      case FrictionLaw::ambrosio:
        return n == 0 ? Ends{-v0, v0} : n == 1 ? mirrored(v0, v1) : mirrored(v1, far);
      case FrictionLaw::threlfall:
      case FrictionLaw::bengisu_akay:
        return n == 1 ? mirrored(0, v0) : mirrored(v0, far);
      case FrictionLaw::lugre:
        return mirrored(0, far);
      default:
        return {-far, far};
    }
  }

  /// c(v) on the branch of `zone`; z as given for LuGre.
  template <class T>
  T coefficient(const T& v, int zone, const std::type_identity_t<T>& z) const {
    using std::exp, std::tanh;
    const double side = zone < 0 ? -1 : 1;
    const T s = side * v;
    const int n = zone < 0 ? -zone : zone;
    switch (law) {
      case FrictionLaw::ambrosio:
        return n == 0 ? T(0) : n == 1 ? T(side * mu * (s - v0) / (v1 - v0)) : T(side * mu);
      case FrictionLaw::threlfall:
        return side * mu * (1 - exp(n == 1 ? T(-3 * s / v0) : T(-3)));
      case FrictionLaw::bengisu_akay:
        return side * (n == 1 ? T(mu_static * (1 - (s / v0 - 1) * (s / v0 - 1)))
                              : T(mu + (mu_static - mu) * exp(-decay * (s - v0))));
      case FrictionLaw::brown_mcphee: {
        const T x = v / v0, d = 0.25 * x * x + 0.75;
        return mu * tanh(4 * x) + (mu_static - mu) * x / (d * d) + viscous * v;
      }
      default:
        return sigma0 * z + sigma1 * bristle_rate(v, zone, z) + viscous * v;
    }
  }
  /// ż of LuGre.
  template <class T>
  T bristle_rate(const T& v, int zone, const std::type_identity_t<T>& z) const {
    using std::exp;
    const T x = v / v0, g = (mu + (mu_static - mu) * exp(-x * x)) / sigma0;
    return g > 0 ? T(v - (zone < 0 ? T(-v) : v) * z / g) : T(0);
  }
};

/// The law of the scene's options for a contact with Coulomb's μ.
inline FrictionForce make_friction(const PenaltyOptions& o, double mu) {
  return {o.friction,
          mu,
          mu * o.friction_static,
          o.friction_v0,
          o.friction_v1,
          o.friction_decay,
          o.friction_viscous,
          o.bristle_stiffness,
          o.bristle_damping};
}

/// Friction of a preloaded joint: linear up to the regularising velocity, then the bound.
template <class T>
T preloaded_friction(double bound, double regularisation, const T& u) {
  const T x = u / regularisation;
  return -bound * (x > 1 ? T(1) : x < -1 ? T(-1) : x);
}

}  // namespace freeplay
