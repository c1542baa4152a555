// A contact problem of many contacts (contact_problem.hpp), in islands: contacts that no part of the mechanism joins do not
// know each other, and D has entries only where two rows touch the same part.
//
// Islands of up to most_dense unknowns are solved as any small problem is. Longer ones have D by rows and
// Newton's method on the projections
//
//     P_N = (P_N − ρ u_N)⁺,    P_T = clamp(P_T − ρ u_T, ±(bound + μP_N))
//
// (Alart and Curnier, Comput. Methods Appl. Mech. Eng. 92 (1991) 353) from the impulses given, with band factors in the order
// of a breadth-first walk over the island (Cuthill and McKee, Proc. 24th ACM Conf. (1969) 157): along a chain its cost is linear.
// Where the band is wide or that fails: Gauss–Seidel over D's rows, and up to most_whole unknowns the solvers of small problems.
// Bodies that no joint holds are swept in their velocities (contact_islands_free.cpp).
#pragma once

#include <array>
#include <span>
#include <vector>

#include "formulations/contact/contact_problem.hpp"
#include "numerics/band_lu.hpp"
#include "numerics/responses.hpp"

namespace freeplay {

class ContactIslands {
 public:
  static constexpr int most_dense = 8, most_whole = 400;

  ContactIslands(const SaddlePoint& saddle, int columns, LcpSolver solver, double tolerance);
  /// The saddle point that all calls until the next use() belong to; it stays where it is so long.
  void use(const SaddlePoint& saddle) { saddle_ = &saddle; }

  /// Forgets all islands: rows and responses are new.
  void clear() { now_ = 0; }
  /// Solves `whole` (its D is not read), whose row r is rows[slot[r]] with the response of the same number, and whose unknown i
  /// is `id[i]`. An island of the same ids as in the last call since clear() keeps its impulses.
  ContactSolution solve(ContactProblem& whole, std::span<const int> slot, std::span<const int> id,
                        const std::vector<SparseRow>& rows, const Responses& responses);

  /// The impulses, of either sign, by which every row's rate vanishes; where rows depend on each other the least. False where
  /// an island's band is wide.
  [[nodiscard]] bool hold(ContactProblem& whole, std::span<const int> slot,
                          const std::vector<SparseRow>& rows, const Responses& responses);

  /// Of the last solve's rows. D is 0 between islands.
  double rate(int row) const;
  double D(int row, int column) const;
  /// Some pressed contact has D_NN ≤ μ|D_NT|.
  bool doubtful() const { return doubtful_; }
  /// Of the last solve the first island that has more motions than one, and its unknowns.
  const ContactProblem& ambiguous() const { return ambiguous_; }
  const std::vector<int>& ambiguous_ids() const { return ambiguous_ids_; }
  int count() const { return now_; }
  int largest() const;

 private:
  struct Island {
    std::vector<int> ids, members, slots;  // of its unknowns; of its rows
    std::vector<ContactUnknown> unknowns;  // with rows of the island
    std::vector<double> b, impulse;        // of its rows
    std::vector<int> begin, column;        // D by rows
    std::vector<double> value;
    ContactSolution found;
    bool doubtful = false;
  };
  /// Takes the unknowns `members` of the whole, with D and b.
  void take(Island& x, const ContactProblem& whole, std::span<const int> slot,
            const std::vector<int>& members, const std::vector<SparseRow>& rows, const Responses& responses);
  int group(const ContactProblem& whole, std::span<const int> slot, const std::vector<SparseRow>& rows);
  bool same(const Island& island, std::span<const int> id, const std::vector<int>& members) const;
  void couple(Island& x, const std::vector<SparseRow>& rows, const Responses& responses);
  void solve_small(Island& x, ContactProblem& whole);
  void solve_long(Island& x, ContactProblem& whole, const std::vector<SparseRow>& rows);
  bool gather_free(const Island& x, const std::vector<SparseRow>& rows);
  void sum_free(const Island& x);
  double residual_free(const Island& x) const;
  bool sweep_free(Island& x, double accepted, int most);
  bool newton(Island& x, double accepted, int most);
  bool gauss_seidel(Island& x, double accepted, int most);
  bool hold(Island& x);
  int order_rows(const Island& x);
  template <class Visit>
  void each_cluster(const SparseRow& row, Visit visit) const;
  static void gather(Island& x);
  static double rate_of(const Island& x, int row);
  static double entry(const Island& x, int row, int column);
  double project(const Island& x, bool with_jacobian, double proximal);
  static double residual(const Island& x);
  static double attainable(const Island& x);

  /// An unknown between bodies that no joint holds: its rows in the columns that they touch, by their places in y_.
  struct Free {
    static constexpr int most = SparseRow::max_size;
    int size = 0;
    std::array<int, most> column{};
    std::array<double, most> normal{}, tangent{}, mobility{};
    double nn = 0, nt = 0, tt = 0, bn = 0, bt = 0;  // of D and b
  };

  const SaddlePoint* saddle_;
  LcpSolver solver_;
  double tolerance_;
  ContactProblem small_, ambiguous_;
  std::vector<int> ambiguous_ids_;
  std::vector<Island> islands_, before_;
  int now_ = 0;  // of islands_ in use
  bool doubtful_ = false;
  std::vector<std::vector<int>> members_;  // of each island, unknowns
  std::vector<int> root_, touched_;        // of clusters: parts, then coordinates that no row touches
  std::vector<int> island_of_cluster_, island_of_id_, island_of_row_, local_of_row_;
  std::vector<int> head_, next_, seen_;  // rows of each cluster of one island
  std::vector<int> place_, walk_;        // order of rows in the band
  BandLu band_;
  std::vector<double> F_, P_, step_, u_, given_, best_;
  std::vector<Free> free_;
  std::vector<int> columns_, place_of_column_;  // of free_
  std::vector<double> y_;                       // m/s, rad/s: what the impulses change
};

}  // namespace freeplay
