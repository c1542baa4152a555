#include "formulations/contact/island_groups.hpp"

#include <algorithm>
#include <cmath>

namespace freeplay {

double SparseIsland::rate(int row) const {
  double u = b[row];
  for (int e = begin[row]; e < begin[row + 1]; ++e) u += value[e] * impulse[column[e]];
  return u;
}

double SparseIsland::entry(int row, int col) const {
  for (int e = begin[row]; e < begin[row + 1]; ++e)
    if (column[e] == col) return value[e];
  return 0;
}

double SparseIsland::rho(int row) const {
  const double d = entry(row, row);
  return d > 0 ? 1 / d : 0;
}

void SparseIsland::act(int row, double by, Eigen::VectorXd& rates) {
  impulse[row] += by;
  for (int e = begin[row]; e < begin[row + 1]; ++e) rates[column[e]] += by * value[e];
}

double SparseIsland::residual() const {
  return contact_residual(unknowns, [&](int row, double) {
    return RowState{rate(row), entry(row, row), impulse[row]};
  });
}

double SparseIsland::attainable() const {
  double most = 0;
  for (std::size_t r = 0; r + 1 < begin.size(); ++r) {
    double sum = std::abs(b[r]);
    for (int e = begin[r]; e < begin[r + 1]; ++e) sum += std::abs(value[e] * impulse[column[e]]);
    most = std::max(most, sum);
  }
  return 1e-13 * most;
}

void SparseIsland::gather() {
  impulse.resize(slots.size());
  for (const auto& u : unknowns) {
    if (u.normal >= 0) impulse[u.normal] = u.impulse_n;
    if (u.tangent >= 0) impulse[u.tangent] = u.impulse_t;
  }
}

void SparseIsland::scatter() {
  for (auto& u : unknowns) {
    u.impulse_n = u.normal >= 0 ? impulse[u.normal] : 0;
    u.impulse_t = u.tangent >= 0 ? impulse[u.tangent] : 0;
  }
}

IslandGroups::IslandGroups(const SaddlePoint& saddle, int columns) : saddle_(&saddle) {
  const auto clusters = static_cast<std::size_t>(saddle.blocks()) + static_cast<std::size_t>(columns);
  root_.assign(clusters, -1);
  island_of_cluster_.assign(clusters, -1);
  head_.assign(clusters, -1);
}

/// Visits the clusters of a row's responses: parts, and coordinates that no constraint involves;
/// some of them twice.
template <class Visit>
void IslandGroups::each_cluster(const SparseRow& row, Visit visit) const {
  int last = -1;
  for (int i = 0; i < row.size; ++i) {
    const int c = row.column[i], p = saddle_->part_of(c);
    const int cluster = p >= 0 ? p : saddle_->free_mobility(c) > 0 ? saddle_->blocks() + c : -1;
    if (cluster >= 0 && cluster != last) visit(last = cluster);
  }
}

/// Joins the clusters of each unknown's rows; members_ lists the islands in the order of their
/// first unknowns.
int IslandGroups::group(const ContactProblem& whole, std::span<const int> slot,
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
    // an unknown that nothing moves is an island by itself
    int island = cluster >= 0 ? island_of_cluster_[cluster] : begin();
    if (island < 0) island = island_of_cluster_[cluster] = begin();
    members_[island].push_back(static_cast<int>(i));
  }
  return islands;
}

void IslandGroups::take(SparseIsland& x, const ContactProblem& whole, std::span<const int> slot,
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

/// D by rows: for each row the rows that share a cluster with it.
void IslandGroups::couple(SparseIsland& x, const std::vector<SparseRow>& rows, const Responses& responses) {
  const int n = static_cast<int>(x.slots.size());
  x.begin.assign(1, 0);
  x.column.clear();
  x.value.clear();
  if (static_cast<int>(x.unknowns.size()) <= most_dense) {  // dense
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
  owner_.clear();
  for (int r = 0; r < n; ++r)
    each_cluster(rows[x.slots[r]], [&](int c) {
      next_.push_back(head_[c]);
      owner_.push_back(r);
      head_[c] = static_cast<int>(next_.size()) - 1;
    });
  seen_.assign(n, -1);
  for (int r = 0; r < n; ++r) {
    each_cluster(rows[x.slots[r]], [&](int c) {
      for (int e = head_[c]; e >= 0; e = next_[e])
        if (seen_[owner_[e]] != r) {
          seen_[owner_[e]] = r;
          x.column.push_back(owner_[e]);
        }
    });
    std::sort(x.column.begin() + x.begin.back(), x.column.end());
    x.begin.push_back(static_cast<int>(x.column.size()));
  }
  for (int r = 0; r < n; ++r) each_cluster(rows[x.slots[r]], [&](int c) { head_[c] = -1; });
  x.value.resize(x.column.size());
  // The lower triangle is computed; seen_ advances through the upper entries of each row in the
  // order of their columns.
  for (int r = 0; r < n; ++r) seen_[r] = x.begin[r];
  for (int r = 0; r < n; ++r)
    for (int e = x.begin[r]; e < x.begin[r + 1] && x.column[e] <= r; ++e) {
      const int s = x.column[e];
      x.value[e] = responses.along(rows[x.slots[r]], x.slots[s]);
      while (x.column[seen_[s]] < r) ++seen_[s];
      x.value[seen_[s]] = x.value[e];
    }
}

}  // namespace freeplay
