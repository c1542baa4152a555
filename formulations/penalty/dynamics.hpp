// The right-hand side of the penalty formulation. Contact forces enter the index-1 equations of motion with
// Baumgarte's stabilisation (Comput. Methods Appl. Mech. Eng. 1 (1972) 1):
//
//     M v̇ + Gᵀλ = f + Σ W_N F_N + W_T F_T,       G v̇ = γ − 2α(Gv + Φ_t) − β²Φ.
//
// The integrated vector is x = [q, v, (P_N, P_T) of each contact, bristles (LuGre), work integrals]. A
// contact is either open or closed for the whole of a step: an open one exerts no force however the trial
// state lies, so each mode's right-hand side is smooth and an event is a root of a smooth function.
#pragma once

#include <vector>

#include "formulations/penalty/contact_law.hpp"
#include "formulations/penalty/film.hpp"
#include "formulations/penalty/friction_law.hpp"
#include "model/scene.hpp"
#include "model/system.hpp"
#include "numerics/saddle_point.hpp"
#include "sim/formulation.hpp"

namespace freeplay {

/// One contact as the penalty formulation carries it.
struct PenaltyContact {
  ContactForce law;
  std::optional<FrictionForce> friction;
  std::optional<Film> film;
  bool closed = false;
  int zone = 0;        ///< of the friction law, while closed
  double deepest = 0;  ///< m, so far
  double v0 = 1;       ///< m/s, δ̇ at first touch of the present contact
};

class PenaltyDynamics {
 public:
  using Vector = std::vector<double>;
  enum Integral { drive, load, damping, contact_loss, friction_loss, film_loss, stabilisation, integrals };

  /// `redundant`: the constraint rows depend on each other.
  PenaltyDynamics(const System& system, const PenaltyOptions& options, std::vector<PenaltyContact> contacts,
                  bool redundant);

  /// dx/dt for odeint.
  void operator()(const Vector& x, Vector& dxdt, double t);

  int size() const { return integral_offset() + integrals; }
  int impulse_offset() const { return 2 * system_.n(); }
  int bristle_offset() const { return impulse_offset() + 2 * system_.contacts(); }
  /// Bristle states, one per contact with LuGre's law, else none.
  int bristles() const { return bristles_; }
  int integral_offset() const { return bristle_offset() + bristles_; }

  /// Gap and its rate of contact k at x.
  std::pair<double, double> gap(int k, const Vector& x, double t);
  /// Fills row() with contact k at x.
  const ContactRow& contact_row(int k, const Vector& x, double t);
  /// Mass that an impact at contact k meets, 1/(W_Nᵀ A W_N) with the constraints kept, at the state of row().
  double effective_mass(const ContactRow& row);
  double elastic_energy(const Vector& x, double t);

  /// Moves x onto Φ = 0 and G v + Φ_t = 0 by the least mass-weighted change, and books what that does to the
  /// energy.
  void project(Vector& x, double t);
  bool projects() const { return projects_; }

  const System& system() const { return system_; }
  std::vector<PenaltyContact>& contacts() { return contacts_; }
  const std::vector<PenaltyContact>& contacts() const { return contacts_; }
  const Evaluation& evaluation() const { return e_; }
  bool singular() const { return singular_; }
  Work work;

 private:
  const System& system_;
  double two_alpha_ = 0, beta_squared_ = 0;
  bool projects_;
  int bristles_ = 0;
  std::vector<PenaltyContact> contacts_;
  SaddlePoint saddle_;
  Evaluation e_, probe_;
  ContactRow row_;
  SparseRow slide_;
  std::vector<double> r_, lambda_, rate_, scratch_, unit_;
  bool singular_ = false;

  double film_forces(const Film& film, const double* v);
};

}  // namespace freeplay
