// The contact problem of one step, as equations. For all active contacts and friction elements,
//
//     u⁺ = D P + b
//     0 ≤ u_N⁺ + e u_N⁻ ⊥ P_N ≥ 0,                                             (Newton)
//     −P_T ∈ μ P_N Sgn(u_T⁺)  or, preloaded,  −P_T ∈ B Sgn(u_T⁺),
//
// where b are the rates at the end of a step without these impulses and D = WᵀAW is the Delassus
// matrix (A maps forces to accelerations with the constraints kept). With tangential restitution,
// u_T⁺ + e_T u_T⁻ takes the place of u_T⁺. At an impact, e and e_T act on approaching contacts only
// (impact.cpp); in time steps, e also acts on separating rates (step_problem.cpp). The same
// problem in accelerations determines the next contact mode.
//
// ContactEquations owns the unknowns, b, and a dense D for small problems. Islands of many contacts
// store D by rows (island_groups.hpp), and islands of bodies without joints store velocities
// instead (free_sweeps.hpp). All storages share the residual below. Solvers (solvers.hpp) read the
// equations and write impulses to `unknowns`.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <vector>

#include "formulations/contact/single_contact.hpp"

namespace freeplay {

/// One set-valued element of the problem and its impulses: the initial guess before a solve, the
/// solution after it. `normal` and `tangent` are rows of D and b, −1 where there is none.
struct ContactUnknown {
  int normal = -1, tangent = -1;
  double friction = 0;  ///< μ of a contact
  double bound = 0;     ///< N s: |P_T| ≤ bound + μ P_N
  /// Lower bound of u_N⁺: −e u_N⁻, 0 without restitution; (1 − λ) u_N⁻ at the end of a piece of
  /// compression (impact_phases.hpp).
  double target_n = 0;
  double target_t = 0;  ///< −e_T u_T⁻: friction opposes the sliding relative to this rate
  double impulse_n = 0, impulse_t = 0;
};

/// State of a row with the present impulses: its rate, its diagonal entry of D, its impulse.
struct RowState {
  double rate, diagonal, impulse;
};

/// Residual of the contact and friction laws, as a rate: the greatest distance of any row to the
/// nearest case of its law. `normal(i)` and `tangent(i)` return the RowState of unknown i.
template <class Normal, class Tangent>
double contact_residual(const std::vector<ContactUnknown>& unknowns, Normal normal, Tangent tangent) {
  double worst = 0;
  const auto take = [&](double x) {
    if (!(std::abs(x) <= worst)) worst = std::isnan(x) ? INFINITY : std::abs(x);
  };
  for (std::size_t i = 0; i < unknowns.size(); ++i) {
    const auto& c = unknowns[i];
    double pressed = 0;
    if (c.normal >= 0) {
      const RowState n = normal(i);
      pressed = n.impulse;
      take(normal_residual(n.diagonal, n.impulse, n.rate - c.target_n));
    }
    if (c.tangent < 0) continue;
    const RowState t = tangent(i);
    const double bound = c.bound + c.friction * std::max(0.0, pressed);
    for (const double x : friction_residuals(t.diagonal, t.impulse, t.rate - c.target_t, bound)) take(x);
  }
  return worst;
}

/// The same where `state(row, impulse)` returns the RowState of a row.
template <class State>
double contact_residual(const std::vector<ContactUnknown>& unknowns, State state) {
  return contact_residual(
      unknowns, [&](std::size_t i) { return state(unknowns[i].normal, unknowns[i].impulse_n); },
      [&](std::size_t i) { return state(unknowns[i].tangent, unknowns[i].impulse_t); });
}

class ContactEquations {
 public:
  /// Makes room for D and b of this many rows and keeps their contents. The room never shrinks.
  void reserve(int size);
  /// Makes room for b alone, where D is stored elsewhere (contact_islands.hpp).
  void reserve_rates(int size);
  void clear() {
    unknowns.clear();
    rows = 0;
  }
  /// Sets a lower limit of the rate that scales residuals, for a problem that is a part of a larger
  /// one.
  void set_least_scale(double scale) { least_scale = scale; }

  /// Residual of the laws with the present impulses, as a rate.
  double residual() const;
  /// Upper bound of the rounding error of the rates with the present impulses.
  double attainable() const;
  /// Greatest |b| and |target|, the scale of residuals.
  double scale() const;
  /// Rate of a row with the present impulses, from D and b.
  double rate(int row) const;
  double entry(int row, int column) const { return D(row, column); }
  /// Adds the change of the rates by a change of this row's impulse.
  void act(int row, double by, Eigen::VectorXd& rates) const {
    rates.head(rows) += by * D.col(row).head(rows);
  }
  /// Whether a pressed contact has D_NN ≤ μ|D_NT| (Painlevé). If there is none, no other motions
  /// are looked for.
  bool doubtful() const;
  bool finite() const { return D.topLeftCorner(rows, rows).allFinite(); }  ///< Whether D is finite.

  /// Numbers the islands of unknowns that D couples; returns the number of islands.
  int label_islands(std::vector<int>& label) const;
  /// Returns the unknowns with label `which` and their rows; `members` gets their numbers in this
  /// problem.
  ContactEquations island(const std::vector<int>& label, int which, std::vector<int>& members) const;
  /// Copies the impulses of an island.
  void take_impulses(const ContactEquations& island, const std::vector<int>& members);

  std::vector<ContactUnknown> unknowns;
  int rows = 0;
  Eigen::MatrixXd D;
  Eigen::VectorXd b;
  double least_scale = 0;
};

}  // namespace freeplay
