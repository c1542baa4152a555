// Friction in ideal joints. In closed form: a pin of radius r carries the force F and resists with
// a couple of at most μ r |F| (the friction circle: F passes the pin's centre at μ r); a guide
// resists with at most μ S. Then a four-bar with friction in all its pivots.
#pragma once

#include <array>
#include <cmath>
#include <utility>

#include "verification/references/numerics.hpp"

namespace freeplay::reference {

/// A wheel that turns on a pin at its centre: F = m g, so ω̇ = −μ r m g/J until it stops.
inline double wheel_deceleration(double mu, double r, double m, double g, double J) {
  return mu * r * m * g / J;
}

/// The same with Stribeck's μ(u) = μ + (μ_s − μ) exp(−(u/v)²), u = r ω: the time from ω₀ down to
/// ω₁, t = ∫ J dω/(r m g μ(rω)), by Simpson's rule on 20 000 intervals.
inline double stribeck_time(double mu, double mu_s, double v, double r, double m, double g, double J,
                            double w0, double w1) {
  const auto slowness = [&](double w) {
    const double x = r * w / v;
    return J / (r * m * g * (mu + (mu_s - mu) * std::exp(-x * x)));
  };
  const int n = 20'000;
  const double h = (w0 - w1) / n;
  double sum = slowness(w1) + slowness(w0);
  for (int i = 1; i < n; ++i) sum += (i % 2 ? 4 : 2) * slowness(w1 + i * h);
  return sum * h / 3;
}

/// A rotor whose centre of mass lies ε off its pin, without weight: |F| = m ε √(ω⁴ + ω̇²) contains
/// ω̇ itself. With
/// k = μ r m ε/J_p, J_p about the pin, ω̇² = k²(ω⁴ + ω̇²): ω̇ = −ω² k/√(1 − k²) for k < 1, and no
/// motion for k ≥ 1.
struct EccentricRotor {
  double mu, r, m, epsilon, J_p;
  double k() const { return mu * r * m * epsilon / J_p; }
  /// ω(t) = ω₀/(1 + c ω₀ t)
  double speed(double w0, double t) const {
    const double c = k() / std::sqrt(1 - k() * k());
    return w0 / (1 + c * w0 * t);
  }
};

/// A rod on a pin, its centre of mass at l, that hits a wall at a with the speed v of that point,
/// Newton's law with e.
/// With w = v/a the impulses P of the wall and Λ of the pin obey J_p (1 + e) w = a P − μ r |Λ| and
/// Λ = m l (1 + e) w − P ≥ 0 (for a beyond the centre of percussion); friction resists the rotation
/// after the impact.
inline double rod_impulse(double mu, double r, double m, double l, double a, double J_p, double e, double v) {
  return (1 + e) * v / a * (J_p + mu * r * m * l) / (a + mu * r);
}

/// A slider of length L on a guide, pulled along it by a force at arm b off the axis: the couple F
/// b presses its ends with
/// 2 F b/L, whose friction is the share k = 2 μ b/L of F. It slides with (1 − k) F/m, and is
/// self-locking for any F where k ≥ 1.
inline double cantilever_share(double mu, double b, double L) { return 2 * mu * b / L; }

// A four-bar with friction in all its pivots, driven at constant speed: the torque of the drive and
// the reactions by Newton and Euler, body by body, with the motion known from the geometry.
//
//     crank    A0 − A + m g = m a₂       (A0 − c₂)×A0 − (A − c₂)×A + τ_A0 − τ_A + T = 0
//     coupler  A − B + m g = m a₃        (A − c₃)×A − (B − c₃)×B + τ_A − τ_B = J₃ α₃
//     rocker   B + B0 + m g = m a₄       (B − c₄)×B + (B0 − c₄)×B0 + τ_B + τ_B0 = J₄ α₄
//
// Forces act on the second body of each pivot (ground–crank, crank–coupler, coupler–rocker,
// ground–rocker), centres of mass lie at the links' middles, and every couple is τ = −μ r |F|
// sgn(ω_second − ω_first) (Coulomb, friction circles of radius μ r; e.g. Hain, Applied Kinematics,
// 1967). The nine equations are linear at given couples, which are iterated.

struct FourBar {
  double crank, coupler, rocker, ground;  ///< m
  std::array<double, 3> mass, inertia;    ///< of crank, coupler, rocker
  double gravity;                         ///< m/s², downwards
  double mu, r;                           ///< of every pivot
  double speed, start;                    ///< rad/s, rad: of the crank
};

struct FourBarForces {
  std::array<std::array<double, 2>, 4> force{};  ///< A0, A, B, B0
  std::array<double, 4> couple{}, spin{};        ///< τ, and ω_second − ω_first
  double torque = 0;                             ///< of the drive, on the crank
};

inline FourBarForces four_bar_forces(const FourBar& b, double t) {
  const double t2 = b.start + b.speed * t, w2 = b.speed;
  const double ax = b.crank * std::cos(t2), ay = b.crank * std::sin(t2);
  // The open branch: B above the line from A to B0.
  const double dx = b.ground - ax, dy = -ay, d = std::hypot(dx, dy);
  const double inner = std::acos((b.coupler * b.coupler + d * d - b.rocker * b.rocker) / (2 * b.coupler * d));
  const double t3 = std::atan2(dy, dx) + inner;
  const double bx = ax + b.coupler * std::cos(t3), by = ay + b.coupler * std::sin(t3);
  // ω₂ ẑ×a + ω₃ ẑ×b = ω₄ ẑ×c, and its rate.
  const double cx = bx - b.ground, cy = by, lx = bx - ax, ly = by - ay;
  const double determinant = ly * cx - lx * cy;
  const auto loop = [&](double rx, double ry) {  // (x, y): −ly x + cy y = rx, lx x − cx y = ry
    return std::pair{-(cx * rx + cy * ry) / determinant, -(ly * ry + lx * rx) / determinant};
  };
  const auto [w3, w4] = loop(w2 * ay, -w2 * ax);
  const auto [a3, a4] =
      loop(w2 * w2 * ax + w3 * w3 * lx - w4 * w4 * cx, w2 * w2 * ay + w3 * w3 * ly - w4 * w4 * cy);

  struct Link {
    double m, J, cx, cy, ax, ay, alpha;
  };
  const Link crank{b.mass[0], b.inertia[0], ax / 2, ay / 2, -w2 * w2 * ax / 2, -w2 * w2 * ay / 2, 0};
  const Link coupler{b.mass[1],
                     b.inertia[1],
                     ax + lx / 2,
                     ay + ly / 2,
                     -w2 * w2 * ax - w3 * w3 * lx / 2 - a3 * ly / 2,
                     -w2 * w2 * ay - w3 * w3 * ly / 2 + a3 * lx / 2,
                     a3};
  const Link rocker{b.mass[2],
                    b.inertia[2],
                    b.ground + cx / 2,
                    cy / 2,
                    -w4 * w4 * cx / 2 - a4 * cy / 2,
                    -w4 * w4 * cy / 2 + a4 * cx / 2,
                    a4};
  const std::array<std::array<double, 2>, 4> at{{{0, 0}, {ax, ay}, {bx, by}, {b.ground, 0}}};
  FourBarForces out;
  out.spin = {w2, w3 - w2, w4 - w3, w4};
  for (int i = 0; i < 200; ++i) {
    std::array<std::array<double, 9>, 9> E{};
    std::array<double, 9> x{};
    // Unknowns: two of each pivot, then the torque; signs of each pivot on each link.
    const auto link = [&](std::size_t row, const Link& l, const std::array<int, 4>& sign, double torque) {
      for (std::size_t p = 0; p < 4; ++p) {
        E[row][2 * p] += sign[p];
        E[row + 1][2 * p + 1] += sign[p];
        E[row + 2][2 * p] -= sign[p] * (at[p][1] - l.cy);
        E[row + 2][2 * p + 1] += sign[p] * (at[p][0] - l.cx);
        x[row + 2] -= sign[p] * out.couple[p];
      }
      E[row + 2][8] = torque;
      x[row] += l.m * l.ax;
      x[row + 1] += l.m * (l.ay + b.gravity);
      x[row + 2] += l.J * l.alpha;
    };
    link(0, crank, {1, -1, 0, 0}, 1);
    link(3, coupler, {0, 1, -1, 0}, 0);
    link(6, rocker, {0, 0, 1, 1}, 0);
    eliminate(E, x);
    double moved = 0, size = 0;
    for (std::size_t p = 0; p < 4; ++p) {
      out.force[p] = {x[2 * p], x[2 * p + 1]};
      const double F = std::hypot(out.force[p][0], out.force[p][1]);
      const double couple = -b.mu * b.r * F * (out.spin[p] > 0 ? 1 : out.spin[p] < 0 ? -1 : 0);
      moved = std::fmax(moved, std::abs(couple - out.couple[p]));
      size = std::fmax(size, std::abs(couple));
      out.couple[p] = couple;
    }
    out.torque = x[8];
    if (moved <= 1e-15 * size) break;
  }
  return out;
}

}  // namespace freeplay::reference
