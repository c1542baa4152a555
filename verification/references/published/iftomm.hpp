// IFToMM benchmarks in closed form or to any instant: Andrews' squeezer (A03), and the row of
// four-bars (A02).
//
// The seven-body mechanism (Andrews' squeezer; IFToMM benchmark A03, IVP test set) to any instant:
// the crank angle β is the coordinate, and the loops give all other angles. With absolute angles
//
//     P = rr e^{iβ} − d e^{iψ₂} = B − i ss e^{iγ} = A + zt e^{iδ} − i e e^{iψ₄}
//       = A − i u e^{iε} + zf e^{iψ₆}
//
// two derivatives of the loops by β give w = dψ/dβ and z = d²ψ/dβ². The state is β, γ, ψ₂, δ, ψ₄,
// ε, ψ₆ and β̇; the closure of the loops is then a check of the integration. Forces: the motor's
// torque and the spring. Units: m, kg, s, rad. Source: parameters of seven_body.hpp (IVP test set);
// equations by hand.
#pragma once

#include <algorithm>
#include <array>
#include <boost/math/special_functions/ellint_1.hpp>
#include <boost/math/special_functions/jacobi_elliptic.hpp>
#include <cmath>

#include "verification/references/published/smooth_motion.hpp"
#include "verification/references/seven_body.hpp"

namespace freeplay::reference {

struct Andrews {
  using Real = long double;
  using State = std::array<Real, 8>;  ///< β, ψ₂, γ, ψ₄, δ, ψ₆, ε, β̇

  // Long double, since doubles of the data would limit the digits.
  Plane A{-.06934L, -.00227L}, B{-.03635L, .03273L}, C{.014L, .072L};
  Real rr = .007L, ra = .00092L, d = .028L, da = .0115L, e = .02L, ea = .01421L, ss = .035L, sc = .018L,
       sd = .02L, u = .04L, zf = .02L, zt = .04L, fa = .01421L, c0 = 4530, l0 = .07785L, torque = .033L;

  State start() const {
    const Real beta = -0.0617138900142764496L, gamma = 0.455279819163070380L, phi = 0.222668390165885885L,
               delta = 0.487364979543842550L, omega = -0.222668390165885885L, epsilon = 1.23054744454982120L;
    return {beta, beta, gamma, phi + delta, delta, omega + epsilon, epsilon, 0};
  }
  State rates(const State& y) const {
    const Plane i = perpendicular;
    const Plane a1 = direction(y[0]), a2 = direction(y[1]), a3 = -i * direction(y[2]),
                a4 = -i * direction(y[3]), a5 = direction(y[4]), a6 = direction(y[5]),
                a7 = -i * direction(y[6]);
    // First and second derivatives by β: of each unit vector i w a, and (i z − w²) a.
    const auto [w2, w3] = components(i * d * a2, i * ss * a3, i * rr * a1);
    const Plane p1 = i * w3 * ss * a3;
    const auto [z2, z3] =
        components(i * d * a2, i * ss * a3, -rr * a1 + w2 * w2 * d * a2 + w3 * w3 * ss * a3);
    const Plane p2 = (i * z3 - w3 * w3) * ss * a3;
    const auto [w4, w5] = components(i * e * a4, i * zt * a5, p1);
    const auto [z4, z5] = components(i * e * a4, i * zt * a5, p2 + w4 * w4 * e * a4 + w5 * w5 * zt * a5);
    const auto [w6, w7] = components(i * zf * a6, i * u * a7, p1);
    const auto [z6, z7] = components(i * zf * a6, i * u * a7, p2 + w6 * w6 * zf * a6 + w7 * w7 * u * a7);

    VirtualWork<1> work;
    const Real rate = y[7], square = rate * rate;
    const std::array<Real, 7> m{.04325L, .00365L, .02373L, .00706L, .07050L, .00706L, .05498L};
    const std::array<Real, 7> I{2.194e-6L, 4.410e-7L, 5.255e-6L, 5.667e-7L, 1.169e-5L, 5.667e-7L, 1.912e-5L};
    const auto body = [&](std::size_t k, Plane r1, Plane r2, Real w, Real z) {
      work.mass(m[k], {r1}, square * r2, 0);
      work.rotation(I[k], {w}, square * z, 0);
    };
    const auto first = [&](Real w, Plane a) { return i * w * a; };
    const auto second = [&](Real w, Real z, Plane a) { return (i * z - w * w) * a; };
    const Plane s3{.01874L, .01043L};  // centre of mass of body 3 over a₃
    const Real t_arm = std::hypot(.02308L, .00916L), u_arm = std::hypot(.01228L, .00449L);
    body(0, first(1, ra * a1), second(1, 0, ra * a1), 1, 0);
    body(1, first(1, rr * a1) - first(w2, da * a2), second(1, 0, rr * a1) - second(w2, z2, da * a2), w2, z2);
    body(2, first(w3, s3 * a3), second(w3, z3, s3 * a3), w3, z3);
    body(3, first(w5, zt * a5) + first(w4, (e - ea) * a4),
         second(w5, z5, zt * a5) + second(w4, z4, (e - ea) * a4), w4, z4);
    body(4, first(w5, t_arm * a5), second(w5, z5, t_arm * a5), w5, z5);
    body(5, first(w7, u * a7) + first(w6, (zf - fa) * a6),
         second(w7, z7, u * a7) + second(w6, z6, (zf - fa) * a6), w6, z6);
    body(6, first(w7, u_arm * a7), second(w7, z7, u_arm * a7), w7, z7);

    const Plane hook = Plane(sc, sd) * a3, arm = B + hook - C;
    const Real reach = std::abs(arm);
    work.force(0, torque - c0 * (reach - l0) / reach * dot(arm, first(w3, hook)));
    return {rate, rate * w2, rate * w3, rate * w4, rate * w5, rate * w6, rate * w7, work.accelerations()[0]};
  }
  State at(Real t, int steps = 4000) const {
    return smooth_motion([this](Real, const State& y) { return rates(y); }, start(), t, steps);
  }
  /// The greatest distance between the common point P by its four chains (m).
  Real opening(const State& y) const {
    const Plane i = perpendicular, P = B - i * ss * direction(y[2]);
    return std::max({std::abs(rr * direction(y[0]) - d * direction(y[1]) - P),
                     std::abs(A + zt * direction(y[4]) - i * e * direction(y[3]) - P),
                     std::abs(A - i * u * direction(y[6]) + zf * direction(y[5]) - P)});
  }
  /// The test set's angles β, Θ, γ, φ, δ, Ω, ε.
  SevenAngles angles(const State& y) const {
    return {double(y[0]), double(y[1] - y[0]), double(y[2]), double(y[3] - y[4]),
            double(y[4]), double(y[5] - y[6]), double(y[6])};
  }
};

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
