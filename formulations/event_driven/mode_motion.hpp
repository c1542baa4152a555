// Motion in a mode, in which every contact is open or closed and every closed one with friction, like every joint with
// friction, sticks or slips one way:
//
//     M v̇ + Gᵀλ = f + Σ (W_N − s μ W_T) λ_N + Σ W_T λ_T,    G v̇ = γ,
//     W_Nᵀ v̇ = γ_N (closed),   W_Tᵀ v̇ = γ_T (sticking),   s = sgn u_T of those that slip.
//
// Friction that its joint's reaction bounds (dynamics/reaction_bound.hpp) is λ_T = −s μ(|u|) S(λ) where it slips, solved with
// the reactions of the same instant (contact/coupled_friction.hpp).
#pragma once

#include <vector>

#include "formulations/event_driven/mode_equations.hpp"

namespace freeplay {

class ModeMotion {
 public:
  using Vector = std::vector<double>;

  /// Accelerations and multipliers of the mode at a state, in d.a, d.lambda and the contacts and joints. False, with the reason in
  /// d.trouble where there is one, if there are none.
  bool solve(ModeEquations& d, const Vector& x, double t);
  /// The same for a report of forces, which a pole does not stop.
  bool solve_for_report(ModeEquations& d, const Vector& x, double t);
  /// The last evaluation lay behind a pole of its forces (Painlevé).
  bool behind_pole() const { return pole_; }
  /// A new mode begins.
  void begin_mode() {
    orientation_ = 0;
    pole_ = false;
  }

 private:
  void hold_rows(ModeEquations& d, const Vector& x);
  void solve_rows(ModeEquations& d);
  void share_friction(ModeEquations& d);
  bool passes_pole(ModeEquations& d);
  bool add_coupled(ModeEquations& d);

  bool reporting_ = false;
  int orientation_ = 0;  // sign of the determinant of what holds, since the mode began
  bool pole_ = false;
  // Of add_coupled(): the rows' forces without that friction and by a unit of each, and multipliers with them.
  Eigen::VectorXd held_forces_;
  std::vector<Eigen::VectorXd> answers_;
  Vector held_reactions_;
};

}  // namespace freeplay
