// ContactIslands: solver of a contact problem with many contacts (contact_equations.hpp), island by
// island (island_groups.hpp).
//
// Islands of up to IslandGroups::most_dense unknowns are solved as dense contact problems. Longer
// islands store D by rows (island_groups.hpp). Islands of bodies without joints are solved by
// Newton's method (newton.hpp) while their rows can be independent, and by sweeps over velocities
// (free_sweeps.hpp), other islands by Newton's method. If these fail, Gauss–Seidel over the rows of
// D follows, and for up to most_whole unknowns the solvers of small problems.
//
// It owns the islands of the last solve and keeps the impulses of unchanged islands until clear().
#pragma once

#include <span>
#include <vector>

#include "formulations/contact/contact_problem.hpp"
#include "formulations/contact/free_sweeps.hpp"
#include "formulations/contact/island_groups.hpp"
#include "formulations/contact/newton.hpp"
#include "numerics/saddle_point.hpp"

namespace freeplay {

class ContactIslands {
 public:
  static constexpr int most_dense = IslandGroups::most_dense, most_whole = 400;

  ContactIslands(const SaddlePoint& saddle, int columns, LcpSolver solver, double tolerance);
  /// Sets the saddle point that all calls until the next use() refer to; it must stay at its
  /// address until then.
  void use(const SaddlePoint& saddle) {
    saddle_ = &saddle;
    groups_.use(saddle);
  }

  /// Discards all islands; called if rows and responses are new.
  void clear() { now_ = 0; }
  /// Solves `whole`, whose D is not read. Its row r is rows[slot[r]] with the response of the same
  /// number, and its unknown i is `id[i]`. An island with the same ids and coefficients of friction
  /// as in the last call since clear() keeps its impulses.
  ContactSolution solve(ContactProblem& whole, std::span<const int> slot, std::span<const int> id,
                        const std::vector<SparseRow>& rows, const Responses& responses);

  /// Computes the impulses, of either sign, for which the rate of every row vanishes; where rows
  /// depend on each other, the least impulses. Returns false if there are none.
  [[nodiscard]] bool hold(ContactProblem& whole, std::span<const int> slot,
                          const std::vector<SparseRow>& rows, const Responses& responses);

  /// Rates of the last solve's rows, and D between them. D is 0 between islands.
  double rate(int row) const;
  double D(int row, int column) const;
  /// Whether a pressed contact has D_NN ≤ μ|D_NT|.
  bool doubtful() const { return doubtful_; }
  /// The first island of the last solve with more than one motion, and its unknowns.
  const ContactProblem& ambiguous() const { return ambiguous_; }
  const std::vector<int>& ambiguous_ids() const { return ambiguous_ids_; }
  int count() const { return now_; }

 private:
  bool same(const SparseIsland& island, const ContactProblem& whole, std::span<const int> id,
            const std::vector<int>& members) const;
  void solve_small(SparseIsland& x, ContactProblem& whole);
  void solve_long(SparseIsland& x, ContactProblem& whole, const std::vector<SparseRow>& rows);

  const SaddlePoint* saddle_;
  int columns_;
  LcpSolver solver_;
  double tolerance_;
  IslandGroups groups_;
  SparseNewton newton_;
  FreeSweeps free_;
  ContactProblem small_, ambiguous_;
  std::vector<int> ambiguous_ids_;
  std::vector<SparseIsland> islands_, before_;
  int now_ = 0;  // number of islands_ in use
  bool doubtful_ = false;
  std::vector<int> island_of_id_, island_of_row_, local_of_row_;
  std::vector<double> given_, best_;
  Eigen::VectorXd rates_;
};

}  // namespace freeplay
