// Steps of Moreau's where contacts are many: responses where they are not zero, contact problems in islands.
#include <fmt/format.h>

#include <algorithm>

#include "formulations/time_stepping/moreau.hpp"

namespace freeplay {

MoreauStepper::Many::Many(const SaddlePoint& saddle, const System& system, const NonsmoothOptions& options,
                          int rows)
    : responses(rows),
      islands(saddle, system.n(), options.solver, options.lcp_tolerance),
      positions(saddle, system.n(), LcpSolver::automatic, options.lcp_tolerance),
      place(static_cast<std::size_t>(rows)),
      taken(static_cast<std::size_t>(rows)) {
  int next = 0;
  for (int k = 0; k < system.contacts(); ++k) {
    first.push_back(next);
    next += system.has_friction(k) ? 2 : 1;
  }
  for (int k = 0; k < system.frictions(); ++k) friction.push_back(next++);
  id.reserve(first.size() + friction.size());
}

void MoreauStepper::Many::begin(SaddlePoint& saddle) {
  responses.use(saddle);
  islands.use(saddle);
  positions.use(saddle);
  std::ranges::fill(taken, 0);
}

/// The response to rows_[place]; with many contacts each is computed once a step.
void MoreauStepper::respond(int place) {
  if (!many_) {
    saddle_.respond(rows_[place], nullptr, 0, response(place), reaction(place), Multipliers::kept);
  } else if (!many_->taken[place]) {
    many_->responses.take(place, rows_[place]);
    many_->taken[place] = 1;
  }
}

void MoreauStepper::respond(int place, const SparseRow* beside, double factor) {
  if (many_)
    many_->responses.take(place, rows_[place], beside, factor);
  else
    saddle_.respond(rows_[place], beside, factor, response(place), reaction(place));
}

double MoreauStepper::along(const SparseRow& row, int place) const {
  return many_ ? many_->responses.along(row, place) : row.dot(response(place));
}

void MoreauStepper::push(int place, double by, double* x) const {
  if (many_) {
    many_->responses.add(place, by, x);
    return;
  }
  for (int i = 0; i < system_.n(); ++i) x[i] += by * response(place)[i];
}

/// Solves the collected problem in islands, and adds its impulses to v. Λ follows by react_to_all().
ContactSolution MoreauStepper::solve_islands() {
  for (int r = 0; r < problem_.rows; ++r) respond(many_->place[r]);
  const auto solve = [&] {
    ++work_.lcp_solves;
    return many_->islands.solve(problem_, many_->place, many_->id, rows_, many_->responses);
  };
  auto result = solve();
  if (!result.solved && strip_restitution()) {
    result.count(work_, extremes_);
    many_->islands.clear();
    result = solve();
    inelastic_ += result.solved;
  }
  result.count(work_, extremes_);
  if (!result.solved) return result;
  if (many_->islands.doubtful()) tell_painleve(result);
  for (const auto& c : problem_.unknowns)
    for (const auto& [row, impulse] : {std::pair{c.normal, c.impulse_n}, std::pair{c.tangent, c.impulse_t}})
      if (row >= 0 && impulse != 0) push(place_of(row), impulse, v_.data());
  return result;
}

/// Brings what lasts in loose joints back to its gap's zero, from either side, as joints are: its status is known, and one
/// linear problem finds what a search for it would a contact at a time. Discs and walls, whose heaps are redundant and
/// whose pairs come and go, are left to the search. True where something has moved.
bool MoreauStepper::hold_lasting() {
  auto& p = position_problem_;
  p.clear();
  for (int k = 0; k < system_.contacts(); ++k) {
    auto& c = contacts_[k];
    c.held = system_.contact_facts(k).has_clearance && c.active && c.unknown >= 0 &&
             problem_.unknowns[c.unknown].impulse_n > 0 && c.row.normal.size > 0 && in_reach(c);
    if (!c.held) continue;
    const int place = many_->first[k];
    many_->place[p.rows] = place;
    rows_[place] = c.row.normal;
    respond(place);
    ContactUnknown u;
    u.normal = p.rows;
    p.b[p.rows++] = c.gap;
    p.unknowns.push_back(u);
  }
  if (p.rows == 0) return false;
  if (!many_->positions.hold(p, many_->place, rows_, many_->responses)) {
    for (auto& c : contacts_) c.held = false;
    return false;
  }
  for (const auto& u : p.unknowns) push(place_of(u.normal), u.impulse_n, q_.data());
  return true;
}

/// The joints' impulses with all that contacts and friction give.
void MoreauStepper::react_to_all() {
  for (const auto& c : problem_.unknowns)
    for (const auto& [row, impulse] : {std::pair{c.normal, c.impulse_n}, std::pair{c.tangent, c.impulse_t}})
      if (row >= 0 && impulse != 0) row_of(row).add_to(force_.data(), impulse);
  saddle_.solve(force_.data(), r_.data(), dq_.data(), lambda_.data());
}

}  // namespace freeplay
