// Elastic force of contacts under a constant load, as a formulation models it.
#pragma once

#include <functional>
#include <vector>

namespace freeplay {

/// A default-constructed Compliance is rigid.
struct Compliance {
  /// F_el (N), its derivative (N/m) and its energy (J) at a penetration δ > 0 (m).
  std::function<double(double)> force, slope, energy;
  explicit operator bool() const { return force != nullptr; }
};
using Compliances = std::vector<Compliance>;  ///< one for each contact; empty: all are rigid

}  // namespace freeplay
