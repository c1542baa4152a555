#include "formulations/contact/contact_islands.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace freeplay {

ContactIslands::ContactIslands(const SaddlePoint& saddle, int columns, LcpSolver solver, double tolerance)
    : saddle_(&saddle), solver_(solver), tolerance_(tolerance), small_(solver, tolerance) {
  const auto clusters = static_cast<std::size_t>(saddle.blocks()) + static_cast<std::size_t>(columns);
  root_.assign(clusters, -1);
  island_of_cluster_.assign(clusters, -1);
  head_.assign(clusters, -1);
}

/// Visits what a row's responses live in: parts, and coordinates that no constraint touches; some twice.
template <class Visit>
void ContactIslands::each_cluster(const SparseRow& row, Visit visit) const {
  int last = -1;
  for (int i = 0; i < row.size; ++i) {
    const int c = row.column[i], p = saddle_->part_of(c);
    const int cluster = p >= 0 ? p : saddle_->free_mobility(c) > 0 ? saddle_->blocks() + c : -1;
    if (cluster >= 0 && cluster != last) visit(last = cluster);
  }
}

/// Joins clusters that an unknown's rows touch; members_ of each island in the order of its first unknown.
int ContactIslands::group(const ContactProblem& whole, std::span<const int> slot,
                          const std::vector<SparseRow>& rows) {
  for (const int c : touched_) root_[c] = island_of_cluster_[c] = -1;
  touched_.clear();
  const auto find = [&](int c) {
    while (root_[c] != c) c = root_[c] = root_[root_[c]];
    return c;
  };
  const auto each_row = [&](const ContactUnknown& u, auto visit) {
    for (const int row : {u.normal, u.tangent})
      if (row >= 0) visit(row);
  };
  const auto first_cluster = [&](const ContactUnknown& u) {
    int first = -1;
    each_row(u, [&](int row) {
      each_cluster(rows[slot[row]], [&](int c) {
        if (root_[c] < 0) {
          root_[c] = c;
          touched_.push_back(c);
        }
        if (first < 0)
          first = c;
        else
          root_[find(c)] = find(first);
      });
    });
    return first;
  };
  for (const auto& u : whole.unknowns) first_cluster(u);
  int islands = 0;
  const auto begin = [&] {
    if (static_cast<int>(members_.size()) == islands) members_.emplace_back();
    members_[islands].clear();
    return islands++;
  };
  for (std::size_t i = 0; i < whole.unknowns.size(); ++i) {
    int cluster = -1;
    each_row(whole.unknowns[i],
             [&](int row) { each_cluster(rows[slot[row]], [&](int c) { cluster = find(c); }); });
    int island = cluster >= 0 ? island_of_cluster_[cluster] : begin();  // that nothing moves, alone
    if (island < 0) island = island_of_cluster_[cluster] = begin();
    members_[island].push_back(static_cast<int>(i));
  }
  return islands;
}

bool ContactIslands::same(const Island& island, std::span<const int> id,
                          const std::vector<int>& members) const {
  return island.ids.size() == members.size() &&
         std::ranges::equal(island.ids, members, {}, {}, [&](int member) { return id[member]; });
}

void ContactIslands::take(Island& x, const ContactProblem& whole, std::span<const int> slot,
                          const std::vector<int>& members, const std::vector<SparseRow>& rows,
                          const Responses& responses) {
  x.members = members;
  x.slots.clear();
  x.unknowns.clear();
  x.b.clear();
  for (const int m : members) {
    auto u = whole.unknowns[m];
    for (int* row : {&u.normal, &u.tangent})
      if (*row >= 0) {
        x.slots.push_back(slot[*row]);
        x.b.push_back(whole.b[*row]);
        *row = static_cast<int>(x.slots.size()) - 1;
      }
    x.unknowns.push_back(u);
  }
  couple(x, rows, responses);
}

bool ContactIslands::hold(ContactProblem& whole, std::span<const int> slot,
                          const std::vector<SparseRow>& rows, const Responses& responses) {
  clear();
  const int islands = group(whole, slot, rows);
  if (islands_.empty()) islands_.resize(1);
  for (int k = 0; k < islands; ++k) {
    auto& x = islands_.front();
    take(x, whole, slot, members_[k], rows, responses);
    if (!hold(x)) return false;
    for (std::size_t i = 0; i < x.members.size(); ++i) {
      auto& u = whole.unknowns[x.members[i]];
      const auto& own = x.unknowns[i];
      if (own.normal >= 0) u.impulse_n = x.impulse[own.normal];
      if (own.tangent >= 0) u.impulse_t = x.impulse[own.tangent];
    }
  }
  return true;
}

ContactSolution ContactIslands::solve(ContactProblem& whole, std::span<const int> slot,
                                      std::span<const int> id, const std::vector<SparseRow>& rows,
                                      const Responses& responses) {
  std::swap(islands_, before_);
  const int before = std::exchange(now_, group(whole, slot, rows));
  if (before == 0) std::ranges::fill(island_of_id_, -1);
  if (static_cast<int>(islands_.size()) < now_) islands_.resize(now_);
  island_of_row_.resize(std::max<std::size_t>(island_of_row_.size(), whole.rows));
  local_of_row_.resize(island_of_row_.size());
  small_.judge_by(whole.scale());
  ContactSolution sum;
  doubtful_ = false;
  for (int k = 0; k < now_; ++k) {
    const auto& members = members_[k];
    auto& x = islands_[k];
    for (const int m : members)
      if (id[m] >= static_cast<int>(island_of_id_.size())) island_of_id_.resize(id[m] + 1, -1);
    const int old = island_of_id_[id[members.front()]];
    const bool kept = old >= 0 && old < before && same(before_[old], id, members);
    if (kept) {
      std::swap(x, before_[old]);
      x.members = members;
    } else {
      take(x, whole, slot, members, rows, responses);
      x.ids.clear();
      for (const int m : members) x.ids.push_back(id[m]);
      if (static_cast<int>(members.size()) <= most_dense)
        solve_small(x, whole);
      else
        solve_long(x, whole, rows);
    }
    for (std::size_t i = 0; i < members.size(); ++i) {
      auto& u = whole.unknowns[members[i]];
      const auto& own = x.unknowns[i];
      u.impulse_n = own.impulse_n;
      u.impulse_t = own.impulse_t;
      for (const auto& [row, local] : {std::pair{u.normal, own.normal}, std::pair{u.tangent, own.tangent}})
        if (row >= 0) {
          island_of_row_[row] = k;
          local_of_row_[row] = local;
        }
    }
    sum.solved = sum.solved && x.found.solved;
    sum.residual = std::max(sum.residual, x.found.residual);
    sum.residual_rate = std::max(sum.residual_rate, x.found.residual_rate);
    sum.retries += kept ? 0 : x.found.retries;
    sum.pivots += kept ? 0 : x.found.pivots;
    sum.ambiguous |= x.found.ambiguous;
    sum.undecided |= x.found.undecided;
    sum.impossible |= x.found.impossible;
    doubtful_ |= x.doubtful;
  }
  for (int k = 0; k < now_; ++k)  // after all, for the entries of the last call are read above
    for (const int own : islands_[k].ids) island_of_id_[own] = k;
  return sum;
}

/// D by rows: of each row the rows that share a cluster with it.
void ContactIslands::couple(Island& x, const std::vector<SparseRow>& rows, const Responses& responses) {
  const int n = static_cast<int>(x.slots.size());
  x.begin.assign(1, 0);
  x.column.clear();
  x.value.clear();
  if (static_cast<int>(x.unknowns.size()) <= most_dense) {  // whole
    x.value.resize(static_cast<std::size_t>(n) * n);
    for (int r = 0; r < n; ++r) {
      for (int s = 0; s < n; ++s) x.column.push_back(s);
      for (int s = 0; s <= r; ++s)
        x.value[r * n + s] = x.value[s * n + r] = responses.along(rows[x.slots[r]], x.slots[s]);
      x.begin.push_back((r + 1) * n);
    }
    return;
  }
  next_.clear();
  std::vector<int>& owner = walk_;  // of each entry of next_
  owner.clear();
  for (int r = 0; r < n; ++r)
    each_cluster(rows[x.slots[r]], [&](int c) {
      next_.push_back(head_[c]);
      owner.push_back(r);
      head_[c] = static_cast<int>(next_.size()) - 1;
    });
  seen_.assign(n, -1);
  for (int r = 0; r < n; ++r) {
    each_cluster(rows[x.slots[r]], [&](int c) {
      for (int e = head_[c]; e >= 0; e = next_[e])
        if (seen_[owner[e]] != r) {
          seen_[owner[e]] = r;
          x.column.push_back(owner[e]);
        }
    });
    std::sort(x.column.begin() + x.begin.back(), x.column.end());
    x.begin.push_back(static_cast<int>(x.column.size()));
  }
  for (int r = 0; r < n; ++r) each_cluster(rows[x.slots[r]], [&](int c) { head_[c] = -1; });
  x.value.resize(x.column.size());
  // The lower triangle is computed; seen_ runs through each row's upper entries as their columns come by.
  for (int r = 0; r < n; ++r) seen_[r] = x.begin[r];
  for (int r = 0; r < n; ++r)
    for (int e = x.begin[r]; e < x.begin[r + 1] && x.column[e] <= r; ++e) {
      const int s = x.column[e];
      x.value[e] = responses.along(rows[x.slots[r]], x.slots[s]);
      while (x.column[seen_[s]] < r) ++seen_[s];
      x.value[seen_[s]] = x.value[e];
    }
}

void ContactIslands::solve_small(Island& x, ContactProblem& whole) {
  const int n = static_cast<int>(x.slots.size());
  small_.clear();
  small_.reserve(n);
  small_.rows = n;
  small_.unknowns = x.unknowns;
  small_.least = whole.least;
  small_.modes_left = whole.modes_left;
  small_.D.topLeftCorner(n, n).setZero();
  for (int r = 0; r < n; ++r) {
    small_.b[r] = x.b[r];
    for (int e = x.begin[r]; e < x.begin[r + 1]; ++e) small_.D(r, x.column[e]) = x.value[e];
  }
  x.found = small_.solve();
  whole.modes_left = small_.modes_left;
  if (x.found.ambiguous) {
    ambiguous_ = small_;
    ambiguous_ids_ = x.ids;
  }
  x.unknowns = small_.unknowns;
  x.doubtful = small_.doubtful();
  gather(x);
}

/// Impulses of the rows from those of the unknowns.
void ContactIslands::gather(Island& x) {
  x.impulse.resize(x.slots.size());
  for (const auto& u : x.unknowns) {
    if (u.normal >= 0) x.impulse[u.normal] = u.impulse_n;
    if (u.tangent >= 0) x.impulse[u.tangent] = u.impulse_t;
  }
}

double ContactIslands::rate_of(const Island& x, int row) {
  double u = x.b[row];
  for (int e = x.begin[row]; e < x.begin[row + 1]; ++e) u += x.value[e] * x.impulse[x.column[e]];
  return u;
}

double ContactIslands::entry(const Island& x, int row, int column) {
  for (int e = x.begin[row]; e < x.begin[row + 1]; ++e)
    if (x.column[e] == column) return x.value[e];
  return 0;
}

double ContactIslands::rate(int row) const {
  return rate_of(islands_[island_of_row_[row]], local_of_row_[row]);
}

double ContactIslands::D(int row, int column) const {
  if (island_of_row_[row] != island_of_row_[column]) return 0;
  return entry(islands_[island_of_row_[row]], local_of_row_[row], local_of_row_[column]);
}

int ContactIslands::largest() const {
  std::size_t most = 0;
  for (int k = 0; k < now_; ++k) most = std::max(most, islands_[k].ids.size());
  return static_cast<int>(most);
}

}  // namespace freeplay
