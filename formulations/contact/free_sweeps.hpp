// FreeSweeps: solver for islands of bodies without joints, such as discs in a box. It sweeps over
// contacts (Gauss–Seidel) in terms of body velocities. The impulses P so far have changed the
// velocities by
//
//     y = M⁻¹ Σ W P,     u = b + Wᵀ y
//
// so that a contact reads and changes only the velocities of its two bodies. This costs 60
// operations per contact, independent of other contacts of these bodies, whereas D by rows has an
// entry for every contact of either body (Jean, Comput. Methods Appl. Mech. Eng. 177 (1999) 235).
// Sweeps alternate in direction, because one sweep carries the weight of a pile to the ground only
// in one direction.
//
// Sweeps find the contact modes (pressed, sticking, sliding) of most contacts quickly, and the impulses
// slowly. Newton's method therefore continues with proximal points (Rockafellar, Math. Oper. Res. 1 (1976)
// 97): from the impulses P⁰ so far it solves for the y with
//
//     M y = Σ W P(u),   P_N = (P_N⁰ − (u_N − target)/(δ D_NN))⁺,
//     P_T = clamp(P_T⁰ − (u_T − target)/(δ D_TT), ±(bound + μ P_N)),
//
// takes P as the next P⁰, and ends where P = P⁰, a solution of the contact problem. The regularisation δ
// makes shared contact forces unique. With a small δ a round reduces the error by up to δ, but contacts
// change their modes together, and Newton's method may fail; with a great one it solves the round in a step
// or two. The rounds therefore choose δ as a trust region chooses its radius. The Jacobian has three rows
// per body and is sparse; its order is kept while the contacts of the island stay the same.
//
// Usage: gather() an island, then solve(). It owns the contacts of the gathered island, y and the
// Jacobian.
#pragma once

#include <array>
#include <vector>

#include "formulations/contact/island_groups.hpp"
#include "numerics/saddle_point.hpp"
#include "numerics/sparse_lu.hpp"

namespace freeplay {

class FreeSweeps {
 public:
  /// Gathers the contacts of an island; returns false if a joint constrains one of its bodies.
  bool gather(const SparseIsland& x, const std::vector<SparseRow>& rows, const SaddlePoint& saddle,
              int columns);
  /// Number of coordinates of the gathered island.
  int columns() const { return static_cast<int>(columns_.size()); }
  /// Solves from the impulses of the gathered island's unknowns.
  SolverSummary solve(SparseIsland& x, double accepted, int most);

 private:
  /// The rows of a contact, over the columns with nonzero entries; columns are places in y_.
  struct Contact {
    static constexpr int most = SparseRow::max_size;
    int size = 0;
    std::array<int, most> column{};
    std::array<double, most> normal{}, tangent{}, mobility{};
    double nn = 0, nt = 0, tt = 0, bn = 0, bt = 0;  // entries of D and b

    /// Rates of the contact at y.
    std::array<double, 2> rates(const std::vector<double>& y) const {
      double un = bn, ut = bt;
      for (int k = 0; k < size; ++k) {
        un += normal[k] * y[column[k]];
        ut += tangent[k] * y[column[k]];
      }
      return {un, ut};
    }
  };
  void sum(const SparseIsland& x);
  double residual(const SparseIsland& x) const;
  bool sweep(SparseIsland& x, bool back, double& moved);
  void analyse();
  class ProximalPoint;
  bool newton(SparseIsland& x, double accepted, int& steps);

  std::vector<Contact> contacts_;
  std::vector<int> columns_, place_of_column_;
  std::vector<double> y_;  // m/s, rad/s: velocity changes by the impulses
  // Jacobian: its factors, its diagonal, and the entries of each contact's block
  std::array<std::vector<int>, 6> lists_;  // work space of analyse()
  SparseLu jacobian_;
  std::vector<int> diagonal_, entries_;
  std::vector<double> mass_, F_, P_, step_, y_before_;
  std::vector<ContactUnknown> before_;
};

}  // namespace freeplay
