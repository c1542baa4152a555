// Poses of a four-bar linkage in closed form. Links d (ground, from A to D), a (crank AB), b
// (coupler BC), c (rocker CD), the crank
// at θ₂ from AD; angles of coupler and rocker from AD too:
//
//     A = cos θ₂ − K₁ − K₂ cos θ₂ + K₃,  B = −2 sin θ₂,  C = K₁ − (K₂ + 1) cos θ₂ + K₃
//     θ₄ = 2 atan[(−B ∓ √(B² − 4AC))/2A]                      − open, + crossed
//     K₁ = d/a,  K₂ = d/c,  K₃ = (a² − b² + c² + d²)/(2ac)
//
// (Freudenstein 1955; Norton, Design of Machinery, section 4.5, whose terms open and crossed apply
// for 0 < θ₂ < π), and the
// coupler along C − B. Whether a link turns fully relative to its neighbour follows from triangle
// inequalities alone: AB does if BD, which is between |a − d| and a + d, stays within the range
// that b and c can span, [|b − c|, b + c].
#pragma once

#include <array>
#include <cmath>

namespace freeplay::reference {

struct FourBarPose {
  double coupler, rocker;  ///< rad, from AD
};

inline FourBarPose four_bar_pose(double d, double a, double b, double c, double crank, bool open) {
  const double K1 = d / a, K2 = d / c, K3 = (a * a - b * b + c * c + d * d) / (2 * a * c);
  const double A = std::cos(crank) - K1 - K2 * std::cos(crank) + K3, B = -2 * std::sin(crank),
               C = K1 - (K2 + 1) * std::cos(crank) + K3;
  const double root = std::sqrt(B * B - 4 * A * C);
  const double rocker = 2 * std::atan2(-B + (open ? -root : root), 2 * A);
  const double x = d + c * std::cos(rocker) - a * std::cos(crank),
               y = c * std::sin(rocker) - a * std::sin(crank);
  return {std::atan2(y, x), rocker};
}

/// Whether a link turns fully relative to the ground (0: crank, 1: rocker), and the coupler
/// relative to its neighbours (2: the crank, 3: the rocker), each by triangle inequalities alone.
inline std::array<bool, 4> turns_fully(double d, double a, double b, double c) {
  // Neighbours p, q span a diagonal from |p − q| to p + q; the others r, s must span all of it.
  const auto full = [](double p, double q, double r, double s) {
    return std::abs(p - q) >= std::abs(r - s) && p + q <= r + s;
  };
  return {full(d, a, b, c), full(d, c, a, b), full(a, b, c, d), full(b, c, a, d)};
}

}  // namespace freeplay::reference
