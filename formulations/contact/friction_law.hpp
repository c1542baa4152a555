// FrictionForce: regularised friction, F_T = −F_N c(v_T), where c is an odd function of the sliding
// speed v. The file of each law, friction/NAME.hpp, has its c and its source; friction_parts.hpp
// defines zones and branches. make_friction() makes the law of a contact from the scene's options.
#pragma once

#include <cmath>
#include <cstdlib>
#include <limits>
#include <type_traits>

#include "formulations/contact/friction_parts.hpp"
#include "generated/friction_laws.hpp"
#include "mechanism/options.hpp"

namespace freeplay {

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

/// Friction of a preloaded joint: linear up to the regularising velocity, then constant at the
/// bound.
template <class T>
T preloaded_friction(double bound, double regularisation, const T& u) {
  const T x = u / regularisation;
  return -bound * (x > 1 ? T(1) : x < -1 ? T(-1) : x);
}

}  // namespace freeplay
