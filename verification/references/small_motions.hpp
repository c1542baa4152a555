// Small vibrations about an equilibrium, derived by hand.
//
//     double pendulum, hanging    M = [J₁ + m₁a₁² + m₂l₁², m₂l₁a₂; ·, J₂ + m₂a₂²],
//                                 K = diag((m₁a₁ + m₂l₁)g, m₂a₂g),
//                                 det(K − ω²M) = 0, a quadratic in ω²
//     slider-crank with a torsional spring, one coordinate θ, by energy:
//                                 U′(θ₀) = 0,  ω² = U″(θ₀)/I(θ₀),
//                                 U = ½k(θ − φ₀)² − Σ m g·c(θ),  I = Σ m|c′|² + J₁ + J₂φ′²
//     journal on Hertz's ground   δ = (mg/K)^⅔,  ω² = 1.5 K √δ/m
//
// θ of the crank from the slider's line, counter-clockwise; derivatives by Taylor's rules of second
// order, in long double.
// Units: m, kg, s, rad, N. Source: Goldstein, Classical Mechanics, ch. 6; derived here.
#pragma once

#include <array>
#include <cmath>

#include "verification/references/numerics.hpp"

namespace freeplay::reference {

struct HangingPair {
  /// upper: mass, inertia about its centre, pivot to centre, pivot to elbow
  double m1, J1, a1, l1;
  double m2, J2, a2;  ///< lower: elbow to centre
  double g;

  /// rad/s, the lower first.
  std::array<double, 2> rates() const {
    const double a = J1 + m1 * a1 * a1 + m2 * l1 * l1, b = m2 * l1 * a2, c = J2 + m2 * a2 * a2;
    const double k1 = (m1 * a1 + m2 * l1) * g, k2 = m2 * a2 * g;
    // (ac − b²) w² − (a k₂ + c k₁) w + k₁k₂ = 0
    const double p = a * c - b * b, s = a * k2 + c * k1, root = std::sqrt(s * s - 4 * p * k1 * k2);
    return {std::sqrt(2 * k1 * k2 / (s + root)), std::sqrt((s + root) / (2 * p))};
  }
};

/// A function's value with its first two derivatives.
struct Taylor {
  long double f = 0, d = 0, dd = 0;
  friend Taylor operator+(const Taylor& a, const Taylor& b) { return {a.f + b.f, a.d + b.d, a.dd + b.dd}; }
  friend Taylor operator*(const Taylor& a, const Taylor& b) {
    return {a.f * b.f, a.d * b.f + a.f * b.d, a.dd * b.f + 2 * a.d * b.d + a.f * b.dd};
  }
  friend Taylor operator*(long double x, const Taylor& a) { return {x * a.f, x * a.d, x * a.dd}; }
  friend Taylor sqrt(const Taylor& a) {
    const long double r = std::sqrt(a.f);
    return {r, a.d / (2 * r), a.dd / (2 * r) - a.d * a.d / (4 * r * r * r)};
  }
};

struct SprungSliderCrank {
  long double r, l;                   ///< crank and rod; centres in their middles
  long double m1, J1, m2, J2, m3;     ///< crank, rod, slider
  long double gx, gy;                 ///< gravity
  long double stiffness, free_angle;  ///< of the spring between ground and crank

  struct At {
    long double slope, curvature;  ///< U′, U″
    long double inertia;           ///< I
    long double rod;               ///< φ
  };
  At at(long double theta) const {
    const Taylor c{std::cos(theta), -std::sin(theta), -std::cos(theta)},
        s{std::sin(theta), std::cos(theta), -std::sin(theta)}, one{1, 0, 0};
    const Taylor sine = (-r / l) * s, cosine = sqrt(one + -1.0L * (sine * sine));
    const Taylor x1 = (r / 2) * c, y1 = (r / 2) * s;
    const Taylor x2 = r * c + (l / 2) * cosine, y2 = r * s + (l / 2) * sine, x3 = r * c + l * cosine;
    const Taylor turn{theta - free_angle, 1, 0};
    const Taylor U = (stiffness / 2) * (turn * turn) + (-m1 * gx) * x1 + (-m1 * gy) * y1 + (-m2 * gx) * x2 +
                     (-m2 * gy) * y2 + (-m3 * gx) * x3;
    const long double rate = sine.d / cosine.f;  // φ′
    return {U.d, U.dd,
            m1 * (x1.d * x1.d + y1.d * y1.d) + m2 * (x2.d * x2.d + y2.d * y2.d) + m3 * x3.d * x3.d + J1 +
                J2 * rate * rate,
            std::asin(sine.f)};
  }
  /// θ₀ between two angles where U′ has opposite signs.
  long double rest(long double low, long double high) const {
    bisect(low, high, 200,
           [&](long double middle) { return (at(middle).slope > 0) != (at(high).slope > 0); });
    return (low + high) / 2;
  }
};

/// m: penetration of a mass at rest on a Hertzian ground of K (N/m^1.5); rad/s of its vibration.
inline double hertz_depth(double weight, double K) { return std::pow(weight / K, 2.0 / 3.0); }
inline double hertz_bounce(double mass, double weight, double K) {
  return std::sqrt(1.5 * K * std::sqrt(hertz_depth(weight, K)) / mass);
}

}  // namespace freeplay::reference
