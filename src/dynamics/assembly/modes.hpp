// Small motions about a place where a mechanism rests. With q = q₀ + Z y, Z a basis of what constraints and closed contacts
// leave, ZᵀMZ = 1, and first-order states z = z₀ + w:
//
//     ÿ + ZᵀDZ ẏ + ZᵀKZ y = ZᵀZ_z w,      ẇ = (∂flow/∂q) Z y + (∂flow/∂z) w
//
// (statics.hpp). A mode e^{st}: without damping and states s² = −(values of ZᵀKZ), else the values of the system of first
// order. A natural frequency is |s|/2π, that of the swing |Im s|/2π, the damping ratio −Re s/|s|; s > 0 runs away.
#pragma once

#include <complex>
#include <string>
#include <vector>

#include "dynamics/assembly/compliance.hpp"
#include "dynamics/assembly/equilibrium.hpp"

namespace freeplay {

struct Mode {
  enum class Kind {
    swing,   ///< a pair s, s*
    decay,   ///< s < 0, real
    growth,  ///< Re s > 0
    free     ///< s = 0: neither returns nor runs away
  };
  Kind kind = Kind::swing;
  std::complex<double> s;  ///< 1/s; Im s ≥ 0
  /// Of coordinates, scaled to 1 m for the farthest that any body's centre or arm's end moves.
  std::vector<std::complex<double>> shape;

  double natural() const;   ///< Hz
  double swinging() const;  ///< Hz
  double damping() const { return s.real() != 0 ? -s.real() / std::abs(s) : 0; }
};

struct Modes {
  std::vector<Mode> modes;  ///< what grows first, then by |s|
  double length = 1;        ///< m, the arm that a turn counts by
};

/// About an equilibrium, or about any other place at rest, `at`: then reactions are those that hold it there as far as they
/// can.
Modes find_modes(const System& system, const Equilibrium& at, const Compliances& elastic);

/// A place as it stands, contacts that touch (within a thousandth of their clearance) and are pressed closed. `left`: the
/// greatest force (N, or N m over length) that no reaction answers.
Equilibrium as_it_stands(const System& system, const State& state, const Compliances& elastic, double& left);

}  // namespace freeplay
