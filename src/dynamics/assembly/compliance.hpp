// How contacts yield to a load that lasts, as a formulation has it.
#pragma once

#include <functional>
#include <vector>

namespace freeplay {

/// A default one does not yield: it is rigid.
struct Compliance {
  /// F_el (N), its derivative (N/m) and its energy (J) at a penetration δ > 0 (m).
  std::function<double(double)> force, slope, energy;
  explicit operator bool() const { return force != nullptr; }
};
using Compliances = std::vector<Compliance>;  ///< one a contact; empty: all are rigid

}  // namespace freeplay
