// A contact problem of many contacts (contact_equations.hpp), in islands (island_groups.hpp).
//
// Islands of up to IslandGroups::most_dense unknowns are solved as any small problem is. Longer ones have D by rows
// (sparse_island.hpp): bodies that no joint holds are swept in their velocities (free_sweeps.hpp), others by Newton's method with
// band factors (band_newton.hpp). Where the band is wide or that fails: Gauss–Seidel over D's rows, and up to most_whole
// unknowns the solvers of small problems.
#pragma once

#include <span>
#include <vector>

#include "formulations/contact/band_newton.hpp"
#include "formulations/contact/contact_problem.hpp"
#include "formulations/contact/free_sweeps.hpp"
#include "formulations/contact/island_groups.hpp"
#include "formulations/contact/sparse_sweeps.hpp"
#include "numerics/responses.hpp"

namespace freeplay {

class ContactIslands {
 public:
  static constexpr int most_dense = IslandGroups::most_dense, most_whole = 400;

  ContactIslands(const SaddlePoint& saddle, int columns, LcpSolver solver, double tolerance);
  /// The saddle point that all calls until the next use() belong to; it stays where it is so long.
  void use(const SaddlePoint& saddle) {
    saddle_ = &saddle;
    groups_.use(saddle);
  }

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
  bool same(const SparseIsland& island, std::span<const int> id, const std::vector<int>& members) const;
  void solve_small(SparseIsland& x, ContactProblem& whole);
  void solve_long(SparseIsland& x, ContactProblem& whole, const std::vector<SparseRow>& rows);

  const SaddlePoint* saddle_;
  int columns_;
  LcpSolver solver_;
  double tolerance_;
  IslandGroups groups_;
  BandNewton newton_;
  FreeSweeps free_;
  ContactProblem small_, ambiguous_;
  std::vector<int> ambiguous_ids_;
  std::vector<SparseIsland> islands_, before_;
  int now_ = 0;  // of islands_ in use
  bool doubtful_ = false;
  std::vector<int> island_of_id_, island_of_row_, local_of_row_;
  std::vector<double> given_, best_, rates_;
};

}  // namespace freeplay
