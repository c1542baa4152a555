// Beads in a column or a row that touch without load, by two models.
//
// Rigid beads of mass m, all contacts in one impact by Newton's law with one restitution e. Contact
// 0 has the floor (or an arriving bead of mass m), contact k lies between beads k and k + 1 of n.
// Rates before: u₀ = −v, u_k = 0. The conditions
//
//     u_N⁺ ≥ −e u_N⁻ ⊥ P_N ≥ 0,   m (v_k⁺ − v_k⁻) = P_{k−1} − P_k
//
// are met by u⁺ = (e v, 0, …, 0): all beads have one speed, and
//
//     floor:    speed e v,                  P_k = (1 + e) m v (n − k) > 0,  k = 0 … n − 1
//     arrival:  speed (1 + e) v/(n + 1),    P_k = (1 + e) m v (n − k)/(n + 1)               > 0,
//               the arriving bead has the speed v (1 − n e)/(n + 1).
//
// D is positive definite, so that no other impulses meet them. Between impacts all beads have the
// same acceleration: with e = 1 the column
// bounces as a single ball.
//
// Elastic beads with Hertz's force F = K δ^{3/2} at each contact: the equations of motion by the
// classical Runge–Kutta method with a fixed step (of fourth order; where a contact begins or ends
// of order 5/2, as δ^{3/2} is not smooth there).
//
// Signs: heights and speeds upwards; along a row, to the right. Units: m, kg, s, K in N/m^{3/2}.
// Source: Glocker, Set-Valued Force Laws (2001), for the conditions; Nesterenko, J. Appl. Mech.
// Tech. Phys. 24 (1983) 733, for the chain.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <stdexcept>
#include <vector>

namespace freeplay::reference {

/// Height of the column above the floor and its velocity upwards, at the time t (s) after its
/// release from rest at height h (m), with e = 1.
struct ColumnMotion {
  double height, speed;
};
inline ColumnMotion elastic_column(double h, double g, double t) {
  const double fall = std::sqrt(2 * h / g);
  if (t < fall) return {h - 0.5 * g * t * t, -g * t};
  const double since = std::fmod(t - fall, 2 * fall);
  return {g * fall * since - 0.5 * g * since * since, g * fall - g * since};
}

/// Speeds (m/s) after a bead with the speed v hits a row of n beads of the same mass at rest.
struct RowImpact {
  double arriving, row;
};
inline RowImpact row_impact(int n, double v, double e) {
  if (n < 1) throw std::invalid_argument("row_impact: a row has a bead");
  return {v * (1 - n * e) / (n + 1), (1 + e) * v / (n + 1)};
}

/// Hertz's stiffness of two spheres of one material, or of one on a plane with R its radius:
/// K = 4/3 E/(2(1 − ν²)) √R.
inline double bead_stiffness(double young, double poisson, double R) {
  return 4.0 / 3 * young / (2 * (1 - poisson * poisson)) * std::sqrt(R);
}

/// A chain of equal beads: contact 0 between a floor at 0 and bead 0, or none; contact k between
/// beads k − 1 and k.
struct HertzChain {
  double mass, radius, gravity;  ///< kg, m, m/s² (towards the floor)
  double floor, between;         ///< N/m^{3/2}; floor 0: none
  std::vector<double> x, v;      ///< m, of the centres; m/s

  void advance(double duration, double step) {
    const auto count = static_cast<long>(std::ceil(duration / step));
    const double h = duration / static_cast<double>(count);
    const std::size_t n = x.size();
    std::array<std::vector<double>, 4> kx, kv;
    std::vector<double> y(n), w(n);
    for (long s = 0; s < count; ++s) {
      for (std::size_t stage = 0; stage < 4; ++stage) {
        const double a = stage == 0 ? 0 : stage == 3 ? h : 0.5 * h;
        for (std::size_t i = 0; i < n; ++i) {
          y[i] = x[i] + (stage == 0 ? 0 : a * kx[stage - 1][i]);
          w[i] = v[i] + (stage == 0 ? 0 : a * kv[stage - 1][i]);
        }
        kx[stage] = w;
        kv[stage] = accelerations(y);
      }
      for (std::size_t i = 0; i < n; ++i) {
        x[i] += h / 6 * (kx[0][i] + 2 * kx[1][i] + 2 * kx[2][i] + kx[3][i]);
        v[i] += h / 6 * (kv[0][i] + 2 * kv[1][i] + 2 * kv[2][i] + kv[3][i]);
      }
    }
  }
  /// J, kinetic energy, potential energy of the weight and elastic energy of the contacts.
  double energy() const {
    double sum = 0;
    for (std::size_t i = 0; i < x.size(); ++i)
      sum +=
          0.5 * mass * v[i] * v[i] + mass * gravity * x[i] + 0.4 * stiffness(i) * std::pow(depth(x, i), 2.5);
    return sum;
  }

 private:
  double stiffness(std::size_t k) const { return k == 0 ? floor : between; }
  double depth(const std::vector<double>& y, std::size_t k) const {
    const double gap = k == 0 ? y[0] - radius : y[k] - y[k - 1] - 2 * radius;
    return gap < 0 ? -gap : 0;
  }
  std::vector<double> accelerations(const std::vector<double>& y) const {
    std::vector<double> a(y.size(), -gravity);
    for (std::size_t k = 0; k < y.size(); ++k) {
      const double force = stiffness(k) * std::pow(depth(y, k), 1.5);
      a[k] += force / mass;
      if (k > 0) a[k - 1] -= force / mass;
    }
    return a;
  }
};

}  // namespace freeplay::reference
