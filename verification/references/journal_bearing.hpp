// Journal bearings in closed form: steady running, squeezing and whirl, and the linear stiffness and
// damping. Symbols: μ viscosity, ω the journal's speed in a bearing at
// rest, R, L, c radius, length and radial clearance, ε = e/c, W the load (N), φ the attitude angle
// from the load to the line of centres.
//
// Steady running, ė = 0:
//     long, full film (Sommerfeld 1904)    W = 12π μωLR³ ε/(c² (2 + ε²) √(1 − ε²)),  φ = π/2
//     long, half-Sommerfeld                W_r = 12 μωLR³ ε²/(c² (2 + ε²)(1 − ε²)),
//                                          W_t = half the full film's
//     short, full film                     W = π μωRL³ ε/(2c² (1 − ε²)^(3/2)),  φ = π/2
//     short, half-Sommerfeld (Ocvirk 1952) W_r = μωRL³ ε²/(c² (1 − ε²)²),
//                                          W_t = half the full film's
// so that tan φ = W_t/W_r is π√(1 − ε²)/(2ε) of the long and π√(1 − ε²)/(4ε) of the short one.
//
// Squeezing by a constant load, ω = 0, full film: with K f′(ε) ε̇ the film's resistance, the
// momentum is
//     m v + K f(ε) = W t + const,   short  K = π μRL³/c², f = ε/(1 − ε²)^(3/2),
//                                 long   K = 12π μLR³/c², f = ε/√(1 − ε²).
//
// An unloaded journal of mass m near the centre of a full film, z = e_x + i e_y, C its resistance
// there:
//     m z̈ + C (ż − ½iω z) = 0,   z = z₀ e^(st),   s = [−C + √(C² + 2imCω)]/(2m):
//     half the speed, and slowly outwards.
//
// Petroff (1883): a concentric journal is braked by 2π μωR³L/c.
// Sources as in Cameron, The Principles of Lubrication (1966), and Pinkus and Sternlicht, Theory of
// Hydrodynamic Lubrication (1961).
#pragma once

#include <array>
#include <cmath>
#include <complex>

#include "verification/references/numerics.hpp"

namespace freeplay::reference {

struct JournalBearing {
  bool is_short = true, cavitated = true;
  double viscosity = 0, radius = 0, length = 0, clearance = 0;  // Pa s, m

  struct Load {
    double radial, tangential;
  };
  /// Load capacity of the film at an eccentricity and speed (rad/s).
  Load load(double e, double omega) const {
    const double pi = 3.14159265358979323846, s2 = 1 - e * e, share = cavitated ? 0.5 : 1;
    const double c2 = clearance * clearance;
    if (is_short) {
      const double unit = viscosity * omega * radius * std::pow(length, 3) / c2;
      return {cavitated ? unit * e * e / (s2 * s2) : 0, share * unit * pi * e / (2 * std::pow(s2, 1.5))};
    }
    const double unit = 12 * viscosity * omega * length * std::pow(radius, 3) / c2;
    return {cavitated ? unit * e * e / ((2 + e * e) * s2) : 0,
            share * unit * pi * e / ((2 + e * e) * std::sqrt(s2))};
  }
  /// Magnitude of the load (N).
  double capacity(double e, double omega) const {
    const auto found = load(e, omega);
    return std::hypot(found.radial, found.tangential);
  }
  /// ε that carries W, by bisection: the load increases with ε.
  double eccentricity(double W, double omega) const {
    double low = 0, high = 1 - 1e-12;
    bisect(low, high, 200, [&](double e) { return capacity(e, omega) < W; });
    return 0.5 * (low + high);
  }
  double attitude(double e, double omega) const {
    const auto found = load(e, omega);
    return std::atan2(found.tangential, found.radial);
  }
  /// N s, of the squeezing.
  double K() const {
    const double pi = 3.14159265358979323846, c2 = clearance * clearance;
    return is_short ? pi * viscosity * radius * std::pow(length, 3) / c2
                    : 12 * pi * viscosity * length * std::pow(radius, 3) / c2;
  }
  double f(double e) const { return is_short ? e / std::pow(1 - e * e, 1.5) : e / std::sqrt(1 - e * e); }
  /// N s/m, resistance of the full film at the centre.
  double centre() const { return K() / clearance; }
  /// N m s, Petroff's friction torque over ω.
  double petroff() const {
    return 2 * 3.14159265358979323846 * viscosity * std::pow(radius, 3) * length / clearance;
  }
};

/// The exponent of a light journal's whirl (1/s).
inline std::complex<double> whirl(double mass, double resistance, double omega) {
  const std::complex<double> i(0, 1);
  return (-resistance + std::sqrt(resistance * resistance + 2.0 * i * mass * resistance * omega)) /
         (2.0 * mass);
}

// Linear stiffness and damping of journal bearings in closed form. The load W is
//
//     W_r = U f_r(ε),  W_t = U f_t(ε);   U = μωRL³/c² (short) or μωLR³/c² (long)
//
// The film force on the journal at rest is (F_r, F_t) = (−W_r, W_t). A displacement (dr, dt) changes
// ε by dr/c and turns the frame (n, t) by dt/(εc):
//
//     K_rr = U f_r'/c,   K_rt = U f_t/(εc),   K_tr = −U f_t'/c,   K_tt = U f_r/(εc)
//
// A rotation ω and a tangential velocity act by w_t = ė_t − ½ω εc alone, and the cavitated region
// does not move to first order, since the pressure vanishes at its ends:
//
//     C_tt = 2U f_t/(ωεc),   C_rt = −2U f_r/(ωεc)
//
// C_rr and C_tr are integrals of the squeeze pressure over the region of the steady film,
// θ ∈ (−π, 0) if cavitated:
//
//     short  p̄ ∝ cos θ/(1 − ε cos θ)³:                    C_rr as below, C_tr = C_rt
//     long   p ∝ (1 − ε cos θ)^(−2) − (1 + ε)^(−2), which vanishes at the widest gap only, so that
//            C_tr ≠ C_rt for the cavitated film:            C_tr = −24 (μLR³/c³)/((1 − ε)(1 + ε)²)
//
// `short_textbook` gives the coefficients of the cavitated short bearing as printed by Friswell,
// Penny, Garvey and Lees, Dynamics of Rotating Machines (2010), p. 177 onwards.

using Matrix2 = std::array<std::array<double, 2>, 2>;

struct JournalCoefficients {
  Matrix2 stiffness, damping;  ///< N/m, N s/m; x along the load, y at 90° in the direction of rotation
};

/// Q A Qᵀ with Q the rotation by `angle`.
inline Matrix2 rotated(const Matrix2& a, double angle) {
  const double c = std::cos(angle), s = std::sin(angle);
  const Matrix2 q{{{c, -s}, {s, c}}};
  Matrix2 r{};
  for (int i = 0; i < 2; ++i)
    for (int j = 0; j < 2; ++j)
      for (int k = 0; k < 2; ++k)
        for (int l = 0; l < 2; ++l) r[i][j] += q[i][k] * a[k][l] * q[j][l];
  return r;
}

inline JournalCoefficients journal_coefficients(const JournalBearing& b, double e, double omega) {
  const double pi = 3.14159265358979323846, s2 = 1 - e * e, c = b.clearance, share = b.cavitated ? 0.5 : 1;
  const double L3 = std::pow(b.length, 3), R3 = std::pow(b.radius, 3);
  double U, fr, ft, dfr, dft, crr, ctr;
  if (b.is_short) {
    U = b.viscosity * omega * b.radius * L3 / (c * c);
    fr = e * e / (s2 * s2);
    dfr = 2 * e * (1 + e * e) / std::pow(s2, 3);
    ft = share * pi * e / (2 * std::pow(s2, 1.5));
    dft = share * pi * (1 + 2 * e * e) / (2 * std::pow(s2, 2.5));
    crr = share * pi * (1 + 2 * e * e) / std::pow(s2, 2.5);
    ctr = -2 * fr / e;
  } else {
    U = b.viscosity * omega * b.length * R3 / (c * c);
    const double d = (2 + e * e) * s2;
    fr = 12 * e * e / d;
    dfr = 24 * e * (2 + std::pow(e, 4)) / (d * d);
    ft = share * 12 * pi * e / ((2 + e * e) * std::sqrt(s2));
    dft = share * 12 * pi * (2 - e * e + 2 * std::pow(e, 4)) / (std::pow(2 + e * e, 2) * std::pow(s2, 1.5));
    crr = share * 12 * pi / std::pow(s2, 1.5);
    ctr = -24 / ((1 - e) * (1 + e) * (1 + e));
  }
  if (!b.cavitated) fr = dfr = ctr = 0;
  const double phi = std::atan2(ft, fr);
  const Matrix2 K{{{dfr, ft / e}, {-dft, fr / e}}}, C{{{crr, -2 * fr / e}, {ctr, 2 * ft / e}}};
  auto result = JournalCoefficients{rotated(K, phi), rotated(C, phi)};
  for (int i = 0; i < 2; ++i)
    for (int j = 0; j < 2; ++j) {
      result.stiffness[i][j] *= U / c;
      result.damping[i][j] *= U / (c * omega);
    }
  return result;
}

/// K c/W and C cω/W of the cavitated short bearing.
inline JournalCoefficients short_textbook(double e) {
  const double pi2 = std::pow(3.14159265358979323846, 2), pi = std::sqrt(pi2), e2 = e * e, s2 = 1 - e2;
  const double h = std::pow(pi2 * s2 + 16 * e2, -1.5), s = std::sqrt(s2);
  const double uu = h * 4 * (pi2 * (2 - e2) + 16 * e2);
  const double uv = h * pi * (pi2 * s2 * s2 - 16 * e2 * e2) / (e * s);
  const double vu = -h * pi * (pi2 * s2 * (1 + 2 * e2) + 32 * e2 * (1 + e2)) / (e * s);
  const double vv = h * 4 * (pi2 * (1 + 2 * e2) + 32 * e2 * (1 + e2) / s2);
  const double cuu = h * 2 * pi * s * (pi2 * (1 + 2 * e2) - 16 * e2) / e;
  const double cuv = -h * 8 * (pi2 * (1 + 2 * e2) - 16 * e2);
  const double cvv = h * 2 * pi * (pi2 * s2 * s2 + 48 * e2) / (e * s);
  // The book's load acts along −v, and its rotation leads from u to v: x = −v, y = u.
  return {{{{vv, -vu}, {-uv, uu}}}, {{{cvv, -cuv}, {-cuv, cuu}}}};
}

/// Critical mass of a rigid rotor times cω²/W, from K c/W and C cω/W; negative or infinite where
/// there is none. Root s = iν of M s² + C s + K.
struct WhirlThreshold {
  double mass, ratio_squared;  ///< (ν/ω)²
};
inline WhirlThreshold whirl_threshold(const JournalCoefficients& j) {
  const auto &K = j.stiffness, &C = j.damping;
  const double k =
      (K[0][0] * C[1][1] + K[1][1] * C[0][0] - K[0][1] * C[1][0] - K[1][0] * C[0][1]) / (C[0][0] + C[1][1]);
  const double ratio =
      ((k - K[0][0]) * (k - K[1][1]) - K[0][1] * K[1][0]) / (C[0][0] * C[1][1] - C[0][1] * C[1][0]);
  return {k / ratio, ratio};
}

/// Solution of m ẍ + C ẋ + K x = 0 at time t: the exponential of its 4 × 4 matrix by scaling and
/// squaring of its Taylor series. Start at rest.
inline std::array<double, 2> small_whirl(const JournalCoefficients& j, double mass,
                                         const std::array<double, 2>& start, double t) {
  using Matrix4 = std::array<std::array<long double, 4>, 4>;
  const auto times = [](const Matrix4& a, const Matrix4& b) {
    Matrix4 r{};
    for (int i = 0; i < 4; ++i)
      for (int k = 0; k < 4; ++k)
        for (int l = 0; l < 4; ++l) r[i][l] += a[i][k] * b[k][l];
    return r;
  };
  constexpr int halvings = 24;
  Matrix4 a{}, sum{}, term{};
  for (int i = 0; i < 2; ++i) {
    a[i][2 + i] = 1;
    for (int k = 0; k < 2; ++k) {
      a[2 + i][k] = -j.stiffness[i][k] / mass;
      a[2 + i][2 + k] = -j.damping[i][k] / mass;
    }
  }
  for (auto& row : a)
    for (auto& x : row) x *= t / std::pow(2.0L, halvings);
  for (int i = 0; i < 4; ++i) sum[i][i] = term[i][i] = 1;
  for (int n = 1; n <= 12; ++n) {
    term = times(term, a);
    for (int i = 0; i < 4; ++i)
      for (int k = 0; k < 4; ++k) {
        term[i][k] /= n;
        sum[i][k] += term[i][k];
      }
  }
  for (int i = 0; i < halvings; ++i) sum = times(sum, sum);
  std::array<double, 2> x{};
  for (int i = 0; i < 2; ++i) x[i] = static_cast<double>(sum[i][0] * start[0] + sum[i][1] * start[1]);
  return x;
}

}  // namespace freeplay::reference
