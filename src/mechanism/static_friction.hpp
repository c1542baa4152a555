// Static value of friction: a coefficient that falls from its value at rest to that of sliding (Stribeck),
//
//     μ(|u|) = μ + (μ_s − μ) exp(−(|u|/v_S)ⁿ)
//
// with the sliding speed u. StaticFriction has the keys of μ_s, v_S and n, which stand beside a key
// `friction` for μ; StribeckCurve is the function, for a force or a torque in place of μ, too.
// Source with exponent 2: B. Armstrong-Hélouvry, P. Dupont, C. Canudas de Wit, Automatica 30 (1994) 1083.
#pragma once

#include <cmath>
#include <optional>

#include "mechanism/keys.hpp"

namespace freeplay {

/// μ(|u|); constant if μ_s = μ.
struct StribeckCurve {
  double friction = 0;  ///< μ of sliding
  double more = 0;      ///< μ_s − μ, ≥ 0
  double stribeck = 1;  ///< m/s, v_S
  double exponent = 2;  ///< n

  template <class T>
  T coefficient(const T& u) const {
    if (more == 0) return T(friction);
    using std::abs, std::exp, std::pow;
    const T x = u / stribeck;
    if (exponent == 2) return friction + more * exp(-x * x);
    return friction + more * exp(-pow(abs(x), exponent));
  }
  /// dμ/du (s/m); at u = 0 with n = 1, that of one side.
  double coefficient_slope(double u) const {
    const double x = std::abs(u / stribeck);
    return -std::copysign(more * exponent / stribeck * std::pow(x, exponent - 1), u) *
           std::exp(-std::pow(x, exponent));
  }
};

struct StaticFriction {
  std::optional<double> static_friction = {};    ///< μ_s at rest, ≥ μ
  std::optional<double> stribeck_speed = {};     ///< m/s
  std::optional<double> stribeck_exponent = {};  ///< n, 1 to 100; empty: 2

  /// μ(|u|) with the coefficient of sliding.
  StribeckCurve curve(double friction) const {
    StribeckCurve c{.friction = friction};
    if (static_friction) c.more = *static_friction - friction;
    if (stribeck_speed) c.stribeck = *stribeck_speed;
    c.exponent = stribeck_exponent.value_or(c.exponent);
    return c;
  }

  static void keys(auto& k, auto& s, double friction) {
    k.take({"static_friction", "", "μ_s at rest, at least friction; required with stribeck_speed"},
           s.static_friction, non_negative);
    k.take({"stribeck_speed", "m/s", "v in μ + (μ_s − μ) exp(−(|u|/v)ⁿ), u the sliding speed"},
           s.stribeck_speed, positive);
    exponent(k, s.stribeck_exponent);
    k.check(s.static_friction.has_value() == s.stribeck_speed.has_value(),
            s.static_friction ? "static_friction" : "stribeck_speed",
            "static_friction and stribeck_speed go together; one of them is missing");
    k.check(!s.stribeck_exponent || s.stribeck_speed, "stribeck_exponent", "goes with stribeck_speed");
    k.check(!s.static_friction || *s.static_friction >= friction, "static_friction",
            "must be at least friction, ", friction);
  }
  /// A peak with a larger exponent has flanks that no step resolves.
  static constexpr Range exponents{[](double x) { return x >= 1 && x <= 100; }, "between 1 and 100"};
  /// The key of the exponent n.
  static void exponent(auto& k, auto& n) {
    k.take({"stribeck_exponent", "", "n in exp(−(|u|/v)ⁿ), v the Stribeck speed; if absent: 2"}, n,
           exponents);
  }
};

}  // namespace freeplay
