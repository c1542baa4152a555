// The least mass-weighted change that takes a state back onto what its mode holds:
//
//     positions:   G Δq = −Φ,           W_Nᵀ Δq = −g       (closed)
//     velocities:  G Δv = −(G v + Φ_t),  W_Nᵀ Δv = −W_Nᵀ v (closed),  W_Tᵀ Δv = −W_Tᵀ v (sticking)
#pragma once

#include <vector>

#include "formulations/event_driven/mode_equations.hpp"

namespace freeplay {

class ModeProjection {
 public:
  /// Positions of x, then its velocities; adds the impulses of the latter to `book`, if there is one. The energy that it took in or
  /// gave out (J).
  double project(ModeEquations& d, std::vector<double>& x, double t, Forces* book);

 private:
  /// What a row belongs to: contact and which of its rows, or a joint with friction.
  struct Owner {
    int contact, friction;
    bool tangent;
  };
  /// Adds to y the least change with G Δ = −residual and the active rows Δ = −b.
  void move(ModeEquations& d, double* y);
  void hold_positions(ModeEquations& d, const double* q, const double* v);
  void hold_velocities(ModeEquations& d, const double* q, const double* v);
  void enter(ModeEquations& d, const double* q, const double* v, Forces& book) const;

  std::vector<double> residual_, change_;
  std::vector<Owner> owners_;
};

}  // namespace freeplay
