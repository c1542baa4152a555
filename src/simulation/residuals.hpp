// Residuals of the constraint rows at a state.
#pragma once

#include <algorithm>
#include <cmath>

#include "dynamics/system.hpp"
#include "values/ledger.hpp"

namespace freeplay {

/// Updates the greatest |Φ| so far from a placed evaluation, separately for rows in m and in rad.
inline void keep_residuals(const System& system, const Evaluation& e, Extremes& extremes) {
  for (int k = 0; k < system.rows(); ++k) {
    double& worst = system.is_angle_row(k) ? extremes.constraint_angle : extremes.constraint_length;
    worst = std::max(worst, std::abs(e.phi[k]));
  }
}

}  // namespace freeplay
