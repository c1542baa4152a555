// Compound pendulum released at rest from the angle θ₀, |θ₀| < π:
//
//     θ̈ = −ω₀² sin θ,                 ω₀² = m g a/(J + m a²)
//     sin(θ/2) = k cd(ω₀ t, k),   θ̇ = −2 ω₀ k k′ sd(ω₀ t, k),   k = sin(θ₀/2),  k′ = cos(θ₀/2)
//     period 4 K(k)/ω₀
//
// cd = cn/dn and sd = sn/dn are Jacobi's functions of modulus k, K the complete integral of the
// first kind. The rate follows from cd′ = −k′² sd/dn and cos(θ/2) = √(1 − k² cd²) = k′/dn.
// Sign convention: θ from the hanging position, counter-clockwise. Units: m, kg, s, rad; J about
// the centre of mass, a its distance from the pivot.
// Source: Whittaker, Analytical Dynamics, on the pendulum; Abramowitz and Stegun, ch. 16 and 17.
#pragma once

#include <boost/math/special_functions/ellint_1.hpp>
#include <boost/math/special_functions/jacobi_elliptic.hpp>
#include <cmath>
#include <stdexcept>

namespace freeplay::reference {

struct Pendulum {
  double mass;       ///< kg
  double inertia;    ///< kg m², about the centre of mass
  double arm;        ///< m, pivot to centre of mass
  double gravity;    ///< m/s²
  double amplitude;  ///< rad, angle of release, in (−π, π)

  /// ω₀ (rad/s) of small oscillations.
  double small_rate() const { return std::sqrt(mass * gravity * arm / (inertia + mass * arm * arm)); }
};

struct PendulumState {
  double angle;  ///< rad
  double rate;   ///< rad/s
};

/// Period (s). K in long double, for 1 − k² loses digits near the top.
inline double pendulum_period(const Pendulum& p) {
  const long double half = std::abs(p.amplitude) / 2.0L;
  return static_cast<double>(4 * boost::math::ellint_1(std::sin(half)) / p.small_rate());
}

/// State at the time t (s) after the release.
inline PendulumState pendulum_state(const Pendulum& p, double t) {
  const double pi = 3.141592653589793238462643383279503;
  if (!(std::abs(p.amplitude) < pi)) throw std::invalid_argument("pendulum_state: need |amplitude| < π");
  const double w = p.small_rate(), side = p.amplitude < 0 ? -1 : 1;
  const long double half = std::abs(p.amplitude) / 2.0L, k = std::sin(half), k_prime = std::cos(half);
  const long double quarter = boost::math::ellint_1(k);
  const long double u = std::fmod(static_cast<long double>(w) * t, 4 * quarter);
  long double cn = 1, dn = 1;
  const long double sn = boost::math::jacobi_elliptic(k, u, &cn, &dn);
  // atan2 of sin(θ/2) = k cn/dn and cos(θ/2) = k′/dn keeps its precision near the top, where asin
  // would not.
  return {side * static_cast<double>(2 * std::atan2(k * cn, k_prime)),
          -side * static_cast<double>(2 * w * k * k_prime * sn / dn)};
}

}  // namespace freeplay::reference
