// ModeProjection: the least mass-weighted change that projects a state onto the constraints of its
// mode,
//
//     positions:   G Δq = −Φ,           W_Nᵀ Δq = −g       (closed)
//     velocities:  G Δv = −(G v + Φ_t),  W_Nᵀ Δv = −W_Nᵀ v (closed),  W_Tᵀ Δv = −W_Tᵀ v (sticking)
#pragma once

#include <vector>

#include "formulations/event_driven/mode_equations.hpp"

namespace freeplay {

class ModeProjection {
 public:
  /// Projects the positions of x, then its velocities; adds the impulses of the latter to
  /// `impulses`, if given. Returns the change of energy (J).
  double project(ModeEquations& d, std::vector<double>& x, double t, Forces* impulses);

 private:
  /// Owner of a row: a contact and which of its rows, or a joint with friction.
  struct Owner {
    int contact, friction;
    bool tangent;
  };
  /// Adds to y the least change Δ with G Δ = −residual and, for active rows, W Δ = −b.
  void move(ModeEquations& d, double* y);
  void hold_positions(ModeEquations& d, const double* q, const double* v);
  void hold_velocities(ModeEquations& d, const double* q, const double* v);
  void enter(ModeEquations& d, const double* q, const double* v, Forces& impulses) const;

  std::vector<double> residual_, change_;
  std::vector<Owner> owners_;
};

}  // namespace freeplay
