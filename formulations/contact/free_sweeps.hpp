// Islands of bodies that no joint holds, as discs in a box are: Gauss–Seidel in their velocities. With the impulses P so far
// the bodies' velocities have changed by
//
//     y = M⁻¹ Σ W P,     u = b + Wᵀ y
//
// so that a contact reads and changes those of its two bodies alone: 60 operations whatever else touches them, where D by
// rows has an entry for every contact of either (Jean, Comput. Methods Appl. Mech. Eng. 177 (1999) 235). Sweeps go to and
// fro, for weight is handed down through a pile in one that goes along with it.
//
// They find soon who presses, sticks and slides, and late how much. So between them Newton's method looks for the y with
//
//     M y = Σ W P(u),   P_N = (P_N⁰ − (u_N − target)/(δ D_NN))⁺,   P_T = clamp(P_T⁰ − (u_T − target)/(δ D_TT), ±(bound + μ P_N))
//
// about the impulses P⁰ so far, which are those of the problem where P = P⁰ (Rockafellar, Math. Oper. Res. 1 (1976) 97): δ makes
// forces unique that contacts share, and an error of the problem's is δ times as much in the next round. Its matrix has
// three rows a body, in a band along a breadth-first walk.
#pragma once

#include <array>
#include <vector>

#include "formulations/contact/sparse_island.hpp"
#include "numerics/band_lu.hpp"
#include "numerics/saddle_point.hpp"

namespace freeplay {

class FreeSweeps {
 public:
  /// Takes the contacts of an island; false where a joint holds one of its bodies.
  bool gather(const SparseIsland& x, const std::vector<SparseRow>& rows, const SaddlePoint& saddle,
              int columns);
  /// From the impulses of the unknowns of the island that was gathered.
  SolverSummary solve(SparseIsland& x, double accepted, int most);

 private:
  /// A contact's rows in the columns that they touch, by their places in y_.
  struct Contact {
    static constexpr int most = SparseRow::max_size;
    int size = 0;
    std::array<int, most> column{};
    std::array<double, most> normal{}, tangent{}, mobility{};
    double nn = 0, nt = 0, tt = 0, bn = 0, bt = 0;  // of D and b

    /// The rates that y gives.
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
  void order_columns();
  double evaluate(SparseIsland& x, double delta, bool with_jacobian);
  bool newton(SparseIsland& x, double accepted, double delta, int& steps);
  void newton_round(SparseIsland& x, double accepted, double delta, int& steps);

  std::vector<Contact> contacts_;
  std::vector<int> columns_, place_of_column_;
  std::vector<double> y_;          // m/s, rad/s: what the impulses change
  std::vector<int> begin_, of_;    // contacts of each column
  std::vector<int> place_, walk_;  // order of columns in the band
  int width_ = -1;                 // of the band; −1: not known yet; all columns: too wide
  BandLu band_;
  std::vector<double> mass_, F_, P_, step_;
  std::vector<ContactUnknown> before_newton_;
};

}  // namespace freeplay
