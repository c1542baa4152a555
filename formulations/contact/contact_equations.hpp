// The contact problem of one step, as equations. Of every active contact and friction element, with b the rates at the end
// of a step without their impulses and D = WᵀAW the Delassus matrix (A: forces to accelerations, constraints
// kept):
//
//     u⁺ = D P + b
//     0 ≤ u_N⁺ + e u_N⁻ ⊥ P_N ≥ 0,                      (Newton; e acts on approach only)
//     −P_T ∈ μ P_N Sgn(u_T⁺)  or, preloaded,  −P_T ∈ B Sgn(u_T⁺).
//
// With tangential restitution u_T⁺ + e_T u_T⁻ stands for u_T⁺. The same problem in accelerations chooses what contacts do
// next.
//
// ContactEquations has D dense, as small problems are; islands of many contacts have it by rows (sparse_island.hpp), and bodies
// that no joint holds their velocities (free_sweeps.hpp). All are judged by the one residual below. Solvers (solvers.hpp) read the
// equations and leave impulses in `unknowns`.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <vector>

namespace freeplay {

/// One set-valued element of the problem and, after a solve, its impulses (before: a guess to start from).
/// Rows of D and b: `normal`, `tangent`, −1 where there is none.
struct ContactUnknown {
  int normal = -1, tangent = -1;
  double friction = 0;  ///< μ of a contact
  double bound = 0;     ///< N s: |P_T| ≤ bound + μ P_N
  double target_n = 0;  ///< −e u_N⁻ for an approaching contact, else 0: u_N⁺ is to be at least this
  double target_t = 0;  ///< −e_T u_T⁻: the rate at which friction does not resist
  double impulse_n = 0, impulse_t = 0;
};

/// A row with the present impulses: its rate, its diagonal of D, its own impulse.
struct RowState {
  double rate, diagonal, impulse;
};

/// What impulses leave of the laws, as rates: for each row the distance to the nearest of its cases. `normal(i)` and
/// `tangent(i)` give the RowState of unknown i.
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
      take(std::min(std::abs(n.diagonal) * n.impulse, n.rate - c.target_n));
    }
    if (c.tangent < 0) continue;
    // −P_T ∈ bound·Sgn(u) is u = 0 or P_T at the bound against u: the distance to the nearer of both.
    const RowState t = tangent(i);
    const double u = t.rate - c.target_t, bound = c.bound + c.friction * std::max(0.0, pressed);
    take(std::min(std::abs(u), t.diagonal * std::abs(t.impulse + std::copysign(bound, u))));
    take(t.diagonal * std::max(0.0, std::abs(t.impulse) - bound));
  }
  return worst;
}

class ContactEquations {
 public:
  /// Makes room for D and b of this many rows and keeps what is there; grows, never shrinks.
  void reserve(int size);
  /// The same for b alone, where D lives elsewhere (contact_islands.hpp).
  void reserve_rates(int size);
  void clear() {
    unknowns.clear();
    rows = 0;
  }
  /// Residuals are judged by no less than this rate, where the problem is a part of a greater one.
  void judge_by(double scale) { least_scale = scale; }

  /// What the present impulses leave of the laws, as rates.
  double residual() const;
  /// What rounding leaves of the laws' rates at the present impulses, at most.
  double attainable() const;
  /// Greatest |b| and |target|: what residuals are judged by.
  double scale() const;
  /// Of a row with the present impulses: what D and b make of them.
  double rate(int row) const;
  /// Whether some pressed contact has D_NN ≤ μ|D_NT| (Painlevé). Where none has, other motions are not looked for.
  bool doubtful() const;
  bool finite() const { return D.topLeftCorner(rows, rows).allFinite(); }  ///< D

  /// Numbers the islands of unknowns that D couples, and how many they are.
  int label_islands(std::vector<int>& label) const;
  /// The unknowns with label `which`, with their rows; `members`: their numbers here.
  ContactEquations island(const std::vector<int>& label, int which, std::vector<int>& members) const;
  /// Takes over the impulses of an island.
  void take_impulses(const ContactEquations& island, const std::vector<int>& members);

  std::vector<ContactUnknown> unknowns;
  int rows = 0;
  Eigen::MatrixXd D;
  Eigen::VectorXd b;
  double least_scale = 0;
};

}  // namespace freeplay
