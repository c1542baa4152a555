#include "formulations/contact/contact_islands.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "formulations/contact/gauss_seidel.hpp"

namespace freeplay {
namespace {

/// Greatest number of unknowns of an island without joints for which dense matrices are an
/// alternative.
constexpr int most_loose = 64;

}  // namespace

ContactIslands::ContactIslands(const SaddlePoint& saddle, int columns, LcpSolver solver, double tolerance)
    : saddle_(&saddle),
      columns_(columns),
      solver_(solver),
      tolerance_(tolerance),
      groups_(saddle, columns),
      small_(solver, tolerance) {}

bool ContactIslands::same(const SparseIsland& island, const ContactProblem& whole, std::span<const int> id,
                          const std::vector<int>& members) const {
  return island.ids.size() == members.size() &&
         std::ranges::equal(island.ids, members, {}, {}, [&](int member) { return id[member]; }) &&
         std::ranges::equal(island.unknowns, members, {}, &ContactUnknown::friction,
                            [&](int member) { return whole.unknowns[member].friction; });
}

bool ContactIslands::hold(ContactProblem& whole, std::span<const int> slot,
                          const std::vector<SparseRow>& rows, const Responses& responses) {
  clear();
  const int islands = groups_.group(whole, slot, rows);
  if (islands_.empty()) islands_.resize(1);
  for (int k = 0; k < islands; ++k) {
    auto& x = islands_.front();
    groups_.take(x, whole, slot, groups_.members(k), rows, responses);
    if (!newton_.hold(x)) return false;
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
  const int before = std::exchange(now_, groups_.group(whole, slot, rows));
  if (before == 0) std::ranges::fill(island_of_id_, -1);
  if (static_cast<int>(islands_.size()) < now_) islands_.resize(now_);
  island_of_row_.resize(std::max<std::size_t>(island_of_row_.size(), whole.rows));
  local_of_row_.resize(island_of_row_.size());
  small_.set_least_scale(whole.scale());
  ContactSolution sum;
  doubtful_ = false;
  for (int k = 0; k < now_; ++k) {
    const auto& members = groups_.members(k);
    auto& x = islands_[k];
    for (const int m : members)
      if (id[m] >= static_cast<int>(island_of_id_.size())) island_of_id_.resize(id[m] + 1, -1);
    const int old = island_of_id_[id[members.front()]];
    const bool kept = old >= 0 && old < before && same(before_[old], whole, id, members);
    if (kept) {
      std::swap(x, before_[old]);
      x.members = members;
    } else {
      groups_.take(x, whole, slot, members, rows, responses);
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
  // in a second loop, because the entries of the last call are read above
  for (int k = 0; k < now_; ++k)
    for (const int own : islands_[k].ids) island_of_id_[own] = k;
  return sum;
}

void ContactIslands::solve_small(SparseIsland& x, ContactProblem& whole) {
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
  x.gather();
}

void ContactIslands::solve_long(SparseIsland& x, ContactProblem& whole, const std::vector<SparseRow>& rows) {
  x.found = {};
  const double size = whole.scale(), accepted = tolerance_ * size;
  x.gather();
  given_ = x.impulse;
  const auto sweeps = [&](int most) {
    x.scatter();
    if (const auto rows = static_cast<Eigen::Index>(x.slots.size()); rates_.size() < rows)
      rates_.resize(rows);
    return sweep_contacts(x, accepted, rates_, most);
  };
  const auto restart = [&] { std::ranges::fill(x.impulse, 0.0); };
  bool solved = false;
  // rounding may keep all solvers from the tolerance: the best result is accepted up to this
  // residual
  double best_rate = 1e-6 * size;
  best_.clear();
  const auto attempt = [&](auto way) {
    if (solved) return;
    const SolverSummary result = way();
    x.found.pivots += result.iterations;
    solved = result.solved;
    if (solved) return;
    ++x.found.retries;
    if (const double left = x.residual(); left < best_rate) {
      best_rate = left;
      best_ = x.impulse;
    }
  };
  const bool free_bodies = free_.gather(x, rows, *saddle_, columns_),
             heap = free_bodies && static_cast<int>(x.unknowns.size()) > most_loose;
  if (free_bodies) {
    // other methods are no closer in acceptable time; the residual is reported
    if (heap) best_rate = 1e-3 * size;
    // Where forces are not unique, as with more rows than coordinates, proximal points are better.
    if (static_cast<int>(x.slots.size()) <= free_.columns()) {
      attempt([&] { return newton_.solve(x, accepted, 20, SparseNewton::Shared::fail); });
      if (!solved) x.impulse = given_;
    }
    attempt([&] {
      const auto result =
          free_.solve(x, accepted, static_cast<int>(x.unknowns.size()) > most_whole ? 4000 : 20000);
      x.gather();
      return result;
    });
  }
  if (solver_ == LcpSolver::gauss_seidel) attempt([&] { return sweeps(2000); });
  attempt([&] { return newton_.solve(x, accepted, 20); });
  if (!heap) {
    attempt([&] {
      x.impulse = given_;
      return sweeps(5000);
    });
    attempt([&] {
      restart();
      return newton_.solve(x, accepted, 100);
    });
  }
  if (!solved && !heap && static_cast<int>(x.unknowns.size()) <= most_whole) {
    const int pivots = x.found.pivots, retries = x.found.retries;
    solve_small(x, whole);
    x.found.pivots += pivots;
    x.found.retries += retries;
    if (x.found.solved) return;
  }
  if (!solved && !best_.empty()) {
    x.impulse = best_;
    solved = true;
  }
  x.found.solved = solved;
  x.found.residual_rate = x.residual();
  x.found.residual = size > 0 ? x.found.residual_rate / size : x.found.residual_rate;
  x.doubtful = false;
  x.scatter();
  for (const auto& c : x.unknowns)
    if (c.normal >= 0 && c.tangent >= 0 && c.impulse_n > 0)
      x.doubtful |= x.entry(c.normal, c.normal) <= c.friction * std::abs(x.entry(c.normal, c.tangent));
  x.found.undecided = x.doubtful;
}

double ContactIslands::rate(int row) const { return islands_[island_of_row_[row]].rate(local_of_row_[row]); }

double ContactIslands::D(int row, int column) const {
  if (island_of_row_[row] != island_of_row_[column]) return 0;
  return islands_[island_of_row_[row]].entry(local_of_row_[row], local_of_row_[column]);
}

}  // namespace freeplay
