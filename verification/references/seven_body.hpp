// The seven-body mechanism (Andrews' squeezer; IVP test set) at one instant, without time
// integration. The mechanism has one degree of freedom, so its positions give its velocities: the
// loops give every rate as a multiple of the crank's, and the crank's follows from energy, with a
// constant torque and one spring,
//
//     ½ J(q) β̇² = M (β − β₀) − ½ c₀ [(l − l₀)² − (l₀ₛ − l₀)²]        (at rest at the start).
//
// Points are complex numbers; angles in the order β, Θ, γ, φ, δ, Ω, ε.
#pragma once

#include <array>
#include <cmath>
#include <complex>

namespace freeplay::reference {

using SevenAngles = std::array<double, 7>;
using Point = std::complex<double>;

inline constexpr SevenAngles seven_body_start{-0.0617138900142764496, 0,
                                              0.455279819163070380,   0.222668390165885885,
                                              0.487364979543842550,   -0.222668390165885885,
                                              1.23054744454982120};
/// At 0.03 s, recomputed in long double by two methods that agree to 12 digits (all but β and Θ of
/// the order 1).
inline constexpr SevenAngles seven_body_end{15.8107711951537,   -15.7563710584118, 0.0408222401196529,
                                            -0.534730116342068, 0.524409965879952, 0.534730116342067,
                                            1.04808074104195};
inline constexpr std::array<double, 7> seven_body_masses{.04325, .00365, .02373, .00706,
                                                         .07050, .00706, .05498};
inline constexpr std::array<double, 7> seven_body_inertias{2.194e-6, 4.410e-7, 5.255e-6, 5.667e-7,
                                                           1.169e-5, 5.667e-7, 1.912e-5};

namespace seven {
inline constexpr Point A{-.06934, -.00227}, B{-.03635, .03273}, C{.014, .072};
inline constexpr double rr = .007, ra = .00092, d = .028, da = .0115, e = .02, ea = .01421, ss = .035,
                        sc = .018, sd = .02, u = .04, zf = .02, zt = .04, fa = .01421, c0 = 4530, l0 = .07785,
                        torque = .033;
// centre of mass of body 3 over e^{iγ}: sb − i sa up to its side
inline constexpr Point s{.01043, -.01874};
inline Point turn(double angle) { return std::polar(1.0, angle); }
/// sin a − i cos a, the direction of links that point downwards at a = 0.
inline Point hang(double angle) { return Point(0, -1) * turn(angle); }
inline const double t_arm = std::hypot(.02308, .00916), u_arm = std::hypot(.01228, .00449);
}  // namespace seven

/// The common point P by its four chains: links 1–2, 3, 5–4, 7–6.
inline std::array<Point, 4> seven_body_points(const SevenAngles& x) {
  using namespace seven;
  return {rr * turn(x[0]) - d * turn(x[0] + x[1]), B + ss * hang(x[2]),
          A + zt * turn(x[4]) + e * hang(x[3] + x[4]), A + u * hang(x[6]) + zf * turn(x[5] + x[6])};
}

/// All rates for a crank rate of `crank` (rad/s): P has the same velocity along every chain.
inline SevenAngles seven_body_rates(const SevenAngles& x, double crank) {
  using namespace seven;
  const Point i(0, 1);
  // a p + b q = v for real p, q
  const auto solve = [](Point a, Point b, Point v) {
    const double det = a.real() * b.imag() - a.imag() * b.real();
    return std::array{(v.real() * b.imag() - v.imag() * b.real()) / det,
                      (a.real() * v.imag() - a.imag() * v.real()) / det};
  };
  // rr iβ̇e^{iβ} − d i(β̇ + Θ̇)e^{i(β+Θ)} = ss iγ̇ hang γ
  const Point carried = i * crank * (rr * turn(x[0]) - d * turn(x[0] + x[1]));
  const auto [Theta, gamma] = solve(i * d * turn(x[0] + x[1]), i * ss * hang(x[2]), carried);
  const Point v = i * gamma * ss * hang(x[2]);
  const Point four = i * e * hang(x[3] + x[4]), six = i * zf * turn(x[5] + x[6]);
  const auto [phi, delta] = solve(four, four + i * zt * turn(x[4]), v);
  const auto [Omega, epsilon] = solve(six, six + i * u * hang(x[6]), v);
  return {crank, Theta, gamma, phi, delta, Omega, epsilon};
}

/// J in T = ½ J β̇².
inline double seven_body_inertia(const SevenAngles& x) {
  using namespace seven;
  const auto w = seven_body_rates(x, 1);
  const Point i(0, 1);
  const Point two = i * (rr * turn(x[0]) - (1 + w[1]) * da * turn(x[0] + x[1]));
  const Point four = i * (w[4] * zt * turn(x[4]) + (w[3] + w[4]) * (e - ea) * hang(x[3] + x[4]));
  const Point six = i * (w[6] * u * hang(x[6]) + (w[5] + w[6]) * (zf - fa) * turn(x[5] + x[6]));
  const double speed[] = {ra * ra,
                          std::norm(two),
                          w[2] * w[2] * std::norm(s),
                          std::norm(four),
                          w[4] * w[4] * t_arm * t_arm,
                          std::norm(six),
                          w[6] * w[6] * u_arm * u_arm};
  const double turns[] = {1, 1 + w[1], w[2], w[3] + w[4], w[4], w[5] + w[6], w[6]};
  double J = 0;
  for (int k = 0; k < 7; ++k)
    J += seven_body_masses[k] * speed[k] + seven_body_inertias[k] * turns[k] * turns[k];
  return J;
}

/// All rates at positions x, from rest at the start (rad/s); the crank turns forwards.
inline SevenAngles seven_body_velocities(const SevenAngles& x) {
  using namespace seven;
  const auto stretch = [](const SevenAngles& y) {
    // B + sc (sin γ − i cos γ) + sd (cos γ + i sin γ)
    return std::abs(B + sc * hang(y[2]) + sd * turn(y[2]) - C) - l0;
  };
  const double now = stretch(x), before = stretch(seven_body_start);
  const double work = torque * (x[0] - seven_body_start[0]) - 0.5 * c0 * (now * now - before * before);
  return seven_body_rates(x, std::sqrt(2 * work / seven_body_inertia(x)));
}

}  // namespace freeplay::reference
