// Small motions about a position of rest. Let q = q₀ + Z y, where Z is a basis of the motions that
// constraints and closed contacts allow, ZᵀMZ = 1, and first-order states z = z₀ + w:
//
//     ÿ + ZᵀDZ ẏ + ZᵀKZ y = ZᵀZ_z w,      ẇ = (∂flow/∂q) Z y + (∂flow/∂z) w
//
// (statics.hpp). A mode is e^{st}. Without damping and states, s² = −κ for the eigenvalues κ of
// ZᵀKZ; else s are the eigenvalues of the first-order system. The natural frequency is |s|/2π, the
// frequency of oscillation |Im s|/2π, the damping ratio −Re s/|s|. A mode with Re s > 0 grows.
#pragma once

#include <complex>
#include <string>
#include <vector>

#include "dynamics/assembly/equilibrium.hpp"
#include "dynamics/assembly/statics.hpp"

namespace freeplay {

struct Mode {
  enum class Kind {
    swing,   ///< oscillation, a pair s, s*
    decay,   ///< s < 0, real
    growth,  ///< Re s > 0
    free     ///< s = 0: neither restored nor growing
  };
  Kind kind = Kind::swing;
  std::complex<double> s;  ///< 1/s; Im s ≥ 0
  /// Amplitudes of the coordinates; the greatest displacement of a body's centre or of an arm's end
  /// is 1 m.
  std::vector<std::complex<double>> shape;

  double natural() const;   ///< Hz
  double swinging() const;  ///< Hz, frequency of oscillation
  double damping() const { return s.real() != 0 ? -s.real() / std::abs(s) : 0; }
};

struct Modes {
  std::vector<Mode> modes;  ///< growing modes first, then by |s|
  double length = 1;        ///< m, length that converts angles
};

/// Modes about an equilibrium, or about another position of rest `at`, whose reactions balance the
/// forces as far as they can.
Modes find_modes(const System& system, const Equilibrium& at, const Compliances& elastic);

/// A position as it is: contacts that touch (within a thousandth of their clearance) and carry a
/// force are closed. `left`: the greatest force (N, or N m over length) that no reaction balances.
Equilibrium as_it_stands(const System& system, const State& state, const Compliances& elastic, double& left);

}  // namespace freeplay
