// FrictionForce: regularised friction, F_T = −F_N c(v_T), where c is an odd function of the sliding
// speed v. The file of each law, friction/NAME.hpp, has its c and its source; law.hpp
// defines zones and branches. make_friction() makes the law of a contact from the scene's options.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <type_traits>

#include "formulations/contact/law.hpp"
#include "generated/friction_laws.hpp"
#include "mechanism/options.hpp"
#include "mechanism/surface.hpp"

namespace freeplay {

/// ShearSpring: tangential compliance of a point contact with slip, in the penalty formulation. The
/// tangential stiffness is κ times the normal one, k_T = κ F_el'(δ) with F_el = K δⁿ. In stick, the
/// shear force y (N) is a state of the contact; v_T is the sliding speed of the bodies:
///
///     stick   ẏ = k_T v_T + y min(0, k̇_T/k_T),     F_T = −y         while |y| ≤ μ F_N
///     slip    F_T = −σ μ F_N,  σ = ±1                               while σ v_s ≥ 0
///
/// While the contact area grows, the force changes by increments; while it shrinks, the force
/// decreases in proportion to k_T. A constant force would generate energy in loading cycles (Elata
/// and Berryman, Mech. Mater. 24 (1996) 229). κ = 2(1 − ν)/(2 − ν) for equal materials: Mindlin's
/// 8 G* a over Hertz's 2 E* a. The sliding velocity v_s of the contact is v_T less the rate of the
/// spring's deflection: with g = F_N/F_el (1 without damping)
///
///     v_s = v_T − σ (μ/κ) [g δ̇ + δ ġ/n − (1 − 1/n) g min(0, δ̇)].
///
/// Sources: friction/mindlin.hpp; κ in K. L. Johnson, Contact Mechanics (1985), section 7.3;
/// docs/theory/tangential-compliance.md.
struct ShearSpring {
  double mu = 0;           ///< μ > 0
  double ratio = 1;        ///< κ > 0
  double exponent = 1.5;   ///< n of F_el = K δⁿ
  double least_force = 0;  ///< N, F_el at a penetration of rounding size

  /// F_T along the tangent for the normal force F_N ≥ 0 (N). Zones are 0 for stick and σ for slip.
  template <class T>
  T force(int zone, const T& normal, const T& y) const {
    return zone == 0 ? T(-y) : T(-zone * mu * normal);
  }
  /// ẏ (N/s) at the depth δ > 0 (m) and its rate (m/s).
  template <class T>
  T rate(int zone, const T& delta, const T& delta_rate, const T& elastic, const T& v_t, const T& y) const {
    if (zone != 0) return T(0);
    T rise = ratio * exponent * elastic / delta * v_t;
    if (delta_rate < 0) rise += y * (exponent - 1) * delta_rate / delta;
    return rise;
  }
  /// J, energy of the spring under the force y.
  double energy(double delta, double elastic, double y) const {
    return delta > 0 ? 0.5 * y * y * delta / (ratio * exponent * elastic) : 0;
  }

  /// Zone at contact onset, with δ̇ > 0 and g there.
  int first_zone(double delta_rate, double g, double v_t) const {
    return ratio * std::abs(v_t) <= mu * g * delta_rate ? 0 : v_t < 0 ? -1 : 1;
  }
  /// The force over its bound, within −1 and 1 in stick.
  double load(double normal, double y) const { return y / (mu * (normal + least_force)); }
  /// v_s in slip (m/s).
  double slip(int zone, double delta, double delta_rate, double g, double g_rate, double v_t) const {
    return v_t - zone * mu / ratio *
                     (g * delta_rate + delta * g_rate / exponent -
                      (1 - 1 / exponent) * g * std::min(0.0, delta_rate));
  }
};

struct FrictionForce : FrictionParameters {
  FrictionLaw law = FrictionLaw::ambrosio;

  bool has_state() const {
    return visit_law(law, [](auto l) { return decltype(l)::bristle; });
  }

  /// Zone of a speed: 0 for the middle zone, if there is one; otherwise with the sign of v.
  int zone(double v) const {
    return visit_law(law, [&](auto l) {
      const auto kinks = l.kinks(*this);
      const double s = std::abs(v);
      if (!l.kink_at_rest && (kinks.empty() || s <= kinks[0])) return 0;
      int n = 1;
      for (std::size_t i = l.kink_at_rest ? 0 : 1; i < kinks.size(); ++i) n += !(s < kinks[i]);
      return v < 0 ? -n : n;
    });
  }
  struct Ends {
    double low, high;
  };
  /// Ends of a zone on the speed axis (m/s).
  Ends ends(int zone) const {
    return visit_law(law, [&](auto l) {
      constexpr double far = std::numeric_limits<double>::infinity();
      const auto kinks = l.kinks(*this);
      const int most = static_cast<int>(kinks.size()), shift = l.kink_at_rest ? 1 : 0;
      // Upper end of zone n.
      const auto end = [&](int n) {
        return n - shift < 0 ? 0 : n - shift < most ? kinks[static_cast<std::size_t>(n - shift)] : far;
      };
      const int n = std::abs(zone);
      if (n == 0 && !l.kink_at_rest) return Ends{-end(0), end(0)};
      return zone < 0 ? Ends{-end(n), -end(n - 1)} : Ends{end(n - 1), end(n)};
    });
  }

  /// c(v) on the branch of `zone`; z is the deflection of the bristle if the law has one.
  template <class T>
  T coefficient(const T& v, int zone, const std::type_identity_t<T>& z) const {
    return visit_law(law, [&](auto l) -> T {
      if constexpr (decltype(l)::bristle)
        return l.coefficient(*this, v, zone < 0 ? T(-v) : v, z);
      else
        return zone < 0 ? T(-l.coefficient(*this, T(-v), -zone)) : l.coefficient(*this, v, zone);
    });
  }
  /// ż; 0 for a law without bristle.
  template <class T>
  T bristle_rate(const T& v, int zone, const std::type_identity_t<T>& z) const {
    return visit_law(law, [&](auto l) -> T {
      if constexpr (decltype(l)::bristle)
        return l.bristle_rate(*this, v, zone < 0 ? T(-v) : v, z);
      else
        return T(0);
    });
  }
  /// c(v) of sliding at the constant speed v.
  double steady(double v) const {
    return visit_law(law, [&](auto l) {
      double z = 0;
      if constexpr (decltype(l)::bristle) z = l.steady_bristle(*this, v);
      return coefficient(v, zone(v), z);
    });
  }
};

/// The friction law of the scene's options for a contact with Coulomb's coefficient μ.
inline FrictionForce make_friction(const PenaltyOptions& o, double mu) {
  return {{mu, mu * o.friction_static, o.friction_v0, o.friction_v1, o.friction_decay, o.friction_viscous,
           o.bristle_stiffness, o.bristle_damping},
          o.friction};
}

/// The same for a surface with friction. Its static value and Stribeck's speed take the place of those of the
/// options; the law must have them (FrictionLawFacts::stribeck).
inline FrictionForce make_friction(const PenaltyOptions& o, const Surface& surface) {
  auto friction = make_friction(o, *surface.friction);
  if (!surface.friction_by_speed()) return friction;
  friction.mu_static = surface.friction_at_rest();
  visit_law(o.friction, [&](auto l) {
    constexpr auto speed = decltype(l)::stribeck;
    if constexpr (speed != nullptr) friction.*speed = *surface.peak.stribeck_speed;
  });
  return friction;
}

/// Friction of a preloaded joint: linear up to the regularising velocity, then constant at the
/// bound.
template <class T>
T preloaded_friction(double bound, double regularisation, const T& u) {
  const T x = u / regularisation;
  return -bound * (x > 1 ? T(1) : x < -1 ? T(-1) : x);
}

}  // namespace freeplay
