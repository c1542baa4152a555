// N parallelograms in a row (IFToMM benchmark A02): N + 1 uprights and N couplers, thin bars of
// mass m and length L. The uprights start upright with the angular velocity −v₀/L, so that the
// heads move with v₀ along x. While the loops remain parallelograms, the angle θ of the uprights
// from the vertical, clockwise, is the only coordinate:
//
//     ½ J θ̇² + W cos θ = const,   J = m L² ((N + 1)/3 + N),   W = m g L ((N + 1)/2 + N)
//
// This is a pendulum that turns over the top. With ψ = θ − π from the lowest position,
//
//     sin(ψ/2) = sn(u, k),   ψ̇ = Ω dn(u, k),   u = Ω t/2 − K(k),
//     Ω² = (v₀/L)² + 4 ω₀²,   k = 2 ω₀/Ω,   ω₀² = W/J
//
// Units: m, kg, s. Source: closed form of the turning pendulum (Whittaker, Analytical Dynamics);
// benchmark: Gonzalez et al., Eng. with Computers 26 (2010) 1.
#pragma once

#include <array>
#include <boost/math/special_functions/ellint_1.hpp>
#include <boost/math/special_functions/jacobi_elliptic.hpp>
#include <cmath>

namespace freeplay::reference {

struct FourBarRow {
  int count = 2;
  long double length = 1, gravity = 9.81L, head_speed = 1;

  /// Place and velocity of the head of an upright from its foot: x, y, vx, vy.
  std::array<double, 4> head(long double t) const {
    const long double n = count;
    const long double w = std::sqrt(gravity / length * ((n + 1) / 2 + n) / ((n + 1) / 3 + n));
    const long double start = head_speed / length, fastest = std::sqrt(start * start + 4 * w * w);
    const long double k = 2 * w / fastest, quarter = boost::math::ellint_1(k);
    long double cn = 1, dn = 1;
    const long double u = std::fmod(fastest * t / 2 - quarter, 4 * quarter);
    const long double sn = boost::math::jacobi_elliptic(k, u, &cn, &dn);
    // of θ = ψ + π
    const long double sine = -2 * sn * cn, cosine = 2 * sn * sn - 1, rate = fastest * dn;
    return {double(length * sine), double(length * cosine), double(length * rate * cosine),
            double(-length * rate * sine)};
  }
};

/// Head of the first upright at 10 s of N = 2 by Exudyn, generalised-α with h = 0.125e-3 s
/// (comments of main/pythonDev/TestModels/fourBarMechanismIftomm.py): x, y, vx, vy.
inline constexpr std::array<double, 4> exudyn_four_bars_fine{0.3284573768, 0.9445187937, 1.423050003,
                                                             -0.4948670827};

}  // namespace freeplay::reference
