// Spring with play in series with a dry-friction slider, quasi-static: the force over a prescribed
// displacement x. With y the place of the slider and e = x − y,
//
//     F = k (e − p) for e > p,   k e for e < 0,   0 within the play p,   |F| ≤ F_c,
//
// where the slider follows such that F = ±F_c as soon as the bound is reached: y = x − p − F_c/k or
// x + F_c/k. The force depends on the path only, not on time, so it is exact at each value of x in a
// monotonic piece. Source: elementary; a play operator (M. A. Krasnosel'skii and A. V. Pokrovskii, Systems with
// Hysteresis, 1989) with a dead zone.
#pragma once

#include <algorithm>
#include <vector>

namespace freeplay::reference {

struct BacklashSlider {
  double play = 0, stiffness = 0, friction = 0;  // m, N/m, N

  /// The forces at successive displacements. `slider`: y at the beginning, m.
  std::vector<double> forces(const std::vector<double>& x, double slider) const {
    std::vector<double> list;
    const double most = play + friction / stiffness, least = -friction / stiffness;
    for (const double at : x) {
      slider = std::clamp(slider, at - most, at - least);
      const double e = at - slider;
      list.push_back(e > play ? stiffness * (e - play) : std::min(0.0, stiffness * e));
    }
    return list;
  }
};

}  // namespace freeplay::reference
