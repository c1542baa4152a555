// Which contacts know each other: those whose rows touch the same part of the mechanism, or the same coordinate that no constraint
// touches. Their clusters are joined to islands; D of an island has entries where two rows share a cluster.
#pragma once

#include <span>
#include <vector>

#include "formulations/contact/sparse_island.hpp"
#include "numerics/responses.hpp"

namespace freeplay {

class IslandGroups {
 public:
  static constexpr int most_dense = 8;  // unknowns of an island whose D is whole

  IslandGroups(const SaddlePoint& saddle, int columns);
  /// The saddle point that all calls until the next use() belong to; it stays where it is so long.
  void use(const SaddlePoint& saddle) { saddle_ = &saddle; }

  /// Numbers the islands of a problem whose row r is rows[slot[r]]; how many they are.
  int group(const ContactProblem& whole, std::span<const int> slot, const std::vector<SparseRow>& rows);
  /// Unknowns of the island k, in the order of the problem.
  const std::vector<int>& members(int k) const { return members_[k]; }
  /// Takes the unknowns `members` of the whole, with D and b.
  void take(SparseIsland& x, const ContactProblem& whole, std::span<const int> slot,
            const std::vector<int>& members, const std::vector<SparseRow>& rows, const Responses& responses);

 private:
  void couple(SparseIsland& x, const std::vector<SparseRow>& rows, const Responses& responses);
  template <class Visit>
  void each_cluster(const SparseRow& row, Visit visit) const;

  const SaddlePoint* saddle_;
  std::vector<std::vector<int>> members_;
  std::vector<int> root_, touched_;  // of clusters: parts, then coordinates that no row touches
  std::vector<int> island_of_cluster_;
  std::vector<int> head_, next_, owner_, seen_;  // rows of each cluster of one island
};

}  // namespace freeplay
