// Balls on a line, numbered from the left; x their displacements, v > 0 to the right.
//
// Gaps: each impact is binary. With the restitution e, two balls leave with
//
//     v₁⁺ = (m₁ v₁ + m₂ v₂ − e m₂ (v₁ − v₂))/(m₁ + m₂),    v₂⁺ = v₁⁺ + e (v₁ − v₂) .
//
// The next impact is that of the pair which closes its gap first; flights are uniform. This is
// exact for rigid balls, and for compliant ones if each contact ends before the next begins.
//
// Touching balls with Hertz's force F = K δ^{3/2}, δ_i = x_i − x_{i+1} > 0, at each contact:
//
//     m ẍ_i = F_{i−1} − F_i .
//
// With equal balls the velocities after the separation of all balls, over that of the striking
// ball, depend on the number of balls alone: (m v²/K)^{2/5} is the only length. The equations are
// integrated by the method of Cooper and Verner in long double. δ^{3/2} is not smooth at contact
// onset and separation, so that the steps grow and shrink in proportion to the time from either.
//
// Source: F. Herrmann, P. Schmälzle, Am. J. Phys. 49 (1981) 761, and S. Hutzler, G. Delaney,
// D. Weaire, F. MacLeod, Am. J. Phys. 72 (2004) 1508, for the model of touching balls. Units: m,
// kg, s.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <stdexcept>
#include <vector>

#include "verification/references/numerics.hpp"

namespace freeplay::reference {

struct BallRow {
  std::vector<long double> mass, velocity, gap;  ///< gap[i] between balls i and i + 1

  /// All impacts until no pair approaches.
  void collide(long double e) {
    for (;;) {
      std::size_t next = gap.size();
      long double wait = INFINITY;
      for (std::size_t i = 0; i < gap.size(); ++i) {
        const long double closing = velocity[i] - velocity[i + 1];
        if (closing > 1e-15L && gap[i] / closing < wait) wait = gap[i] / closing, next = i;
      }
      if (next == gap.size()) return;
      for (std::size_t i = 0; i < gap.size(); ++i) gap[i] -= wait * (velocity[i] - velocity[i + 1]);
      gap[next] = 0;
      const long double a = mass[next], b = mass[next + 1], u = velocity[next], w = velocity[next + 1];
      velocity[next] = (a * u + b * w - e * b * (u - w)) / (a + b);
      velocity[next + 1] = velocity[next] + e * (u - w);
    }
  }
};

/// Velocities after a row of N equal touching balls with Hertz contacts has separated; `before`:
/// velocities at first contact.
template <std::size_t N>
std::array<long double, N> touching_row_velocities(const std::array<long double, N>& before) {
  using Real = long double;
  const CooperVerner<Real> method;
  std::array<Real, 2 * N> y{};  // x, v with m = K = 1
  for (std::size_t i = 0; i < N; ++i) y[N + i] = before[i];
  const auto depth = [](const auto& s, std::size_t i) { return s[i] - s[i + 1]; };
  const auto rate = [&](Real, const std::array<Real, 2 * N>& s) {
    std::array<Real, 2 * N> d{};
    for (std::size_t i = 0; i < N; ++i) d[i] = s[N + i];
    for (std::size_t i = 0; i + 1 < N; ++i) {
      const Real delta = depth(s, i), force = delta > 0 ? delta * std::sqrt(delta) : 0;
      d[N + i] -= force, d[N + i + 1] += force;
    }
    return d;
  };
  const Real least = 1e-10L;
  Real since = 0;  // the last onset or separation
  for (int steps = 0; steps < 100000; ++steps) {
    Real h = std::min(0.02L, 0.05L * since + least);
    bool apart = true;
    for (std::size_t i = 0; i + 1 < N; ++i) {
      const Real delta = depth(y, i), closing = y[N + i] - y[N + i + 1];
      apart = apart && delta <= 0 && closing <= 0;
      if (delta * closing < 0) h = std::min(h, std::max(least, 0.05L * std::abs(delta / closing)));
    }
    if (apart && steps > 0) {
      std::array<Real, N> after;
      std::copy(y.begin() + N, y.end(), after.begin());
      return after;
    }
    const auto next = method.step(rate, Real(0), y, h);
    since += h;
    for (std::size_t i = 0; i + 1 < N; ++i)
      if ((depth(y, i) > 0) != (depth(next, i) > 0)) since = 0;
    y = next;
  }
  throw std::runtime_error("touching_row_velocities: the balls do not separate");
}

}  // namespace freeplay::reference
