// IslandGroups: partition of contacts into islands. Two contacts are coupled if their rows involve
// the same part of the mechanism, or the same coordinate that no constraint involves. These parts
// and coordinates, the clusters, are joined to islands; D of an island has entries where two rows
// share a cluster.
#pragma once

#include <span>
#include <vector>

#include "formulations/contact/contact_problem.hpp"
#include "numerics/saddle_point.hpp"

namespace freeplay {

/// SparseIsland: a contact problem of coupled contacts (contact_equations.hpp) with D stored by
/// rows, for islands of many contacts. D has entries only where two rows involve the same part of
/// the mechanism.
struct SparseIsland {
  double rate(int row) const;
  double entry(int row, int column) const;
  /// Changes a row's impulse and the rates, which depend on it by D, a symmetric matrix.
  void act(int row, double by, Eigen::VectorXd& rates);
  double rho(int row) const;  ///< 1/D_rr, 0 where the row cannot move
  double residual() const;
  /// Upper bound of the rounding error of the rates with the present impulses.
  double attainable() const;
  /// Copies the impulses of the unknowns to the rows (gather) and back (scatter).
  void gather();
  void scatter();

  std::vector<int> ids, members, slots;  // ids and members of its unknowns; slots of its rows
  std::vector<ContactUnknown> unknowns;  // with row numbers of the island
  std::vector<double> b, impulse;        // of its rows
  std::vector<int> begin, column;        // D by rows
  std::vector<double> value;
  ContactSolution found;
  bool doubtful = false;
};

class IslandGroups {
 public:
  static constexpr int most_dense = 8;  // greatest number of unknowns of an island with dense D

  IslandGroups(const SaddlePoint& saddle, int columns);
  /// Sets the saddle point that all calls until the next use() refer to; it must stay at its
  /// address until then.
  void use(const SaddlePoint& saddle) { saddle_ = &saddle; }

  /// Numbers the islands of a problem whose row r is rows[slot[r]]; returns the number of islands.
  int group(const ContactProblem& whole, std::span<const int> slot, const std::vector<SparseRow>& rows);
  /// Unknowns of island k, in the order of the problem.
  const std::vector<int>& members(int k) const { return members_[k]; }
  /// Copies the unknowns `members` of the whole problem with their D and b to `x`.
  void take(SparseIsland& x, const ContactProblem& whole, std::span<const int> slot,
            const std::vector<int>& members, const std::vector<SparseRow>& rows, const Responses& responses);

 private:
  void couple(SparseIsland& x, const std::vector<SparseRow>& rows, const Responses& responses);
  template <class Visit>
  void each_cluster(const SparseRow& row, Visit visit) const;

  const SaddlePoint* saddle_;
  std::vector<std::vector<int>> members_;
  // of clusters: parts, then coordinates that no constraint involves
  std::vector<int> root_, touched_;
  std::vector<int> island_of_cluster_;
  // lists of the rows of each cluster, for one island
  std::vector<int> head_, next_, owner_, seen_;
};

}  // namespace freeplay
