// ModeMotion: the motion in a mode. Every contact is open or closed, and every closed contact with
// friction and every joint with friction sticks or slips in one direction:
//
//     M v̇ + Gᵀλ = f + Σ (W_N − s μ W_T) λ_N + Σ W_T λ_T,    G v̇ = γ,
//     W_Nᵀ v̇ = γ_N (closed),   W_Tᵀ v̇ = γ_T (sticking),   s = sgn u_T (slipping).
//
// Slipping friction that its joint's reaction bounds (dynamics/evaluation.hpp) is λ_T = −s
// μ(|u|) S(λ), solved together with the reactions of the same instant
// (contact/coupled_friction.hpp).
#pragma once

#include <vector>

#include "dynamics/motion_kernel.hpp"
#include "formulations/event_driven/mode_equations.hpp"

namespace freeplay {

class ModeMotion {
 public:
  using Vector = std::vector<double>;

  /// Computes accelerations and multipliers of the mode at a state, in d.a, d.lambda and the
  /// contacts and joints. Returns false if there are none, with the reason in d.trouble if it is
  /// known.
  bool solve(ModeEquations& d, const Vector& x, double t);
  /// The same by compiled functions, if there are any for the mode: no contact is closed, or one that
  /// slides or has no friction. d.rows is then empty. The power of drives has the reactions' part,
  /// `sliding` is u_T of the closed contact.
  struct Compiled {
    double drive, sliding;
  };
  bool solve_compiled(ModeEquations& d, const Vector& x, double t, Compiled& found);
  /// The same for a report of forces; a pole does not stop it.
  bool solve_for_report(ModeEquations& d, const Vector& x, double t);
  /// Whether the last evaluation was beyond a pole of its forces (Painlevé).
  bool behind_pole() const { return pole_; }
  /// Called when a new mode begins.
  void begin_mode() {
    orientation_ = 0;
    pole_ = false;
  }

 private:
  void hold_rows(ModeEquations& d, const Vector& x);
  void solve_rows(ModeEquations& d);
  static ReactionBound::Reactions reactions_with_rows(const ModeEquations& d, const ReactionBound& bound);
  void share_friction(ModeEquations& d);
  void admit(ModeEquations& d, bool of_choice, double zero);
  bool passes_pole(ModeEquations& d);
  bool add_coupled(ModeEquations& d);

  bool reporting_ = false;
  MotionKernel kernel_;
  int orientation_ = 0;  // sign of the determinant of the active rows, since the mode began
  bool pole_ = false;
  Eigen::MatrixXd conditions_;  // of admit()
  Eigen::VectorXd constants_;
  // Of add_coupled(): the row forces without this friction, those per unit of each friction force,
  // and the multipliers with them.
  Eigen::VectorXd held_forces_;
  std::vector<Eigen::VectorXd> answers_;
  Vector held_reactions_;
};

}  // namespace freeplay
