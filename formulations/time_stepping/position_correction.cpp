#include "formulations/time_stepping/position_correction.hpp"

#include <algorithm>
#include <limits>

#include "simulation/residuals.hpp"

namespace freeplay {
namespace {

using Multipliers = SaddlePoint::Multipliers;

void place_end(StepData& s) { s.system.place_near(s.t, s.q.data(), s.q_mid.data(), s.middle, s.end); }

void move(StepData& s, const std::vector<double>& dq) {
  for (int i = 0; i < s.system.n(); ++i) s.q[i] += dq[i];
}

void look(const StepData& s, ContactSet& contacts) {
  for (const int k : contacts.live()) contacts[k].gap = contacts.gap(k, s.q.data(), s.end);
}

/// Rounding error (m) of gaps between many bodies. In a row of bodies that just fits between two
/// walls, not all gaps can be free of it, and trying to correct it in every step would cost more
/// than the steps.
double rounding_of_places(const StepData& s) {
  double farthest = 0;
  for (int i = 0; i < s.system.n(); ++i)
    if (i % 3 != 2) farthest = std::max(farthest, std::abs(s.q[i]));
  return 8 * std::numeric_limits<double>::epsilon() * farthest;
}

/// The greatest overlap of contacts that may act in the step (m, ≤ 0).
double deepest(const StepData& s, const ContactSet& contacts) {
  double least = 0;
  for (const int k : contacts.live())
    if (contacts.in_reach(contacts[k], s.reach)) least = std::min(least, contacts[k].gap);
  return least;
}

/// The displacement between a curve of time and the mean of its end rates is driven too: its work
/// against gravity and springs is assigned to the drives. (It is part of the displacement by
/// meet_constraints().)
void book_leads(StepData& s) {
  const int first_driven = s.system.rows() - s.system.drive_rows();
  for (int k = 0; k < s.system.rows(); ++k) {
    const bool timed = k >= first_driven && (s.middle.phi_t[k] != 0 || s.end.phi_t[k] != 0);
    s.r[k] = timed ? -s.end.phi[k] : 0;
  }
  s.saddle.solve(nullptr, s.r.data(), s.dq.data(), s.dlambda.data(), Multipliers::kept);
  for (int i = 0; i < s.system.n(); ++i) s.dq[i] += s.q[i];
  const double lift = s.system.potential(s.dq.data()) - s.system.potential(s.q.data());
  s.totals.integrals.drive += lift;
  s.totals.integrals.stabilisation -= lift;
}

/// One Newton step onto Φ(q⁺, t⁺) = 0.
void meet_constraints(StepData& s) {
  for (int k = 0; k < s.system.rows(); ++k) s.r[k] = -s.end.phi[k];
  s.saddle.solve(nullptr, s.r.data(), s.dq.data(), s.dlambda.data(), Multipliers::kept);
  move(s, s.dq);
  place_end(s);
}

}  // namespace

PositionCorrection::PositionCorrection(const StepData& step, double tolerance, bool many)
    : tolerance_(tolerance), problem_(LcpSolver::automatic, tolerance) {
  const int contacts = step.system.contacts();
  if (!many) {
    problem_.reserve(contacts);
    return;
  }
  problem_.reserve_rates(contacts);
  islands_ = std::make_unique<ContactIslands>(step.saddle, step.system.n(), LcpSolver::automatic, tolerance);
  place_.reserve(static_cast<std::size_t>(contacts));
  id_.reserve(static_cast<std::size_t>(contacts));
}

void PositionCorrection::bring_back(StepData& s, ContactSet& contacts, const StepProblem& problem,
                                    ImpulseResponses& responses, FilmStep& films) {
  if (islands_) islands_->use(s.saddle);
  const bool potential = s.system.has_potential();
  const double before = potential ? s.system.potential(s.whole ? s.dq.data() : s.q.data()) : 0;
  if (!s.whole) {
    if (films.any()) films.displace(s.q.data(), [&](int k) { return contacts[k].unknown >= 0; });
    place_end(s);
    if (s.system.has_motions()) book_leads(s);
    if (s.system.rows() > 0) meet_constraints(s);
    contacts.keep_near(0, s.q.data(), nullptr, nullptr, s, responses);
    look(s, contacts);
  }
  const bool held = islands_ && hold_lasting(s, contacts, problem, responses);
  if (held) {
    place_end(s);
    look(s, contacts);
  }
  const double rounding = islands_ ? rounding_of_places(s) : 0;
  bool moved = false;
  for (const int k : contacts.live()) {
    const auto& c = contacts[k];
    moved |= c.gap < -rounding && contacts.in_reach(c, s.reach) && !(held && c.held);
  }
  if (moved) open_gaps(s, contacts, problem, responses, films.any());
  if (s.smooth()) draw_closed(s, contacts, problem, responses);
  if (potential) s.totals.integrals.stabilisation += s.system.potential(s.q.data()) - before;
  if (moved) contacts.keep_near(0, s.q.data(), nullptr, nullptr, s, responses);
  auto& extremes = s.totals.extremes;
  for (const int k : contacts.live()) {
    auto& c = contacts[k];
    if (moved || s.smooth()) c.gap = contacts.gap(k, s.q.data(), s.end);
    auto& most = extremes.penetration[contacts.reported_index(k)];
    if (contacts.in_reach(c, s.reach)) most = std::max(most, -c.gap);
  }
  if (!s.whole || moved) keep_residuals(s.system, s.end, extremes);
}

/// Adds a contact's gap to the problem; its row is at this place.
void PositionCorrection::add(const StepContact& contact, int place) {
  if (islands_) place_.push_back(place);
  ContactUnknown u;
  u.normal = problem_.rows;
  problem_.b[problem_.rows++] = contact.gap;
  problem_.unknowns.push_back(u);
}

/// Corrects lasting contacts of joints with clearance to zero gap from either side, like joints.
/// Their status is known, and one linear problem replaces a search that changes the status of one
/// contact at a time. Discs and walls are left to that search, because their heaps are redundant
/// and their pairs change. Returns true if anything moved.
bool PositionCorrection::hold_lasting(StepData& s, ContactSet& contacts, const StepProblem& problem,
                                      ImpulseResponses& responses) {
  problem_.clear();
  place_.clear();
  for (int k = 0; k < s.system.contacts(); ++k) {
    auto& c = contacts[k];
    const auto* u = problem.unknown_of(c);
    c.held = s.system.contact_facts(k).has_clearance && c.active && u && u->impulse_n > 0 &&
             c.row.normal.size > 0 && contacts.in_reach(c, s.reach);
    if (!c.held) continue;
    const int place = responses.first(k);
    responses.row(place) = c.row.normal;
    responses.respond(s.saddle, place);
    add(c, place);
  }
  if (problem_.rows == 0) return false;
  if (!islands_->hold(problem_, place_, responses.rows(), responses.sparse())) {
    for (auto& c : contacts.all()) c.held = false;
    return false;
  }
  for (const auto& u : problem_.unknowns) responses.push(place(u.normal), u.impulse_n, s.q.data());
  return true;
}

void PositionCorrection::open_gaps(StepData& s, ContactSet& contacts, const StepProblem& problem,
                                   ImpulseResponses& responses, bool films) {
  problem_.clear();
  place_.clear();
  id_.clear();
  if (problem_.b.size() < static_cast<Eigen::Index>(contacts.all().size()))
    problem_.reserve_rates(static_cast<int>(contacts.all().size()));
  for (const int k : contacts.live()) {
    const auto& c = contacts[k];
    if (c.row.normal.size == 0 || !contacts.in_reach(c, s.reach) || (c.gap >= 0 && c.unknown < 0)) continue;
    const int place = islands_ ? responses.first(k) : problem_.rows;
    if (islands_) id_.push_back(k);
    // The velocity problem has computed the response to this row if it is at the same place.
    const auto* u = problem.unknown_of(c);
    const bool known = !islands_ && !films && u && u->normal == place;
    if (!known) {
      responses.row(place) = c.row.normal;
      responses.respond(s.saddle, place);
    }
    add(c, place);
  }
  const auto result = solve(responses);
  s.totals.work.pivots += result.pivots;
  if (result.solved) {
    if (result.residual > tolerance_) report(s, result.residual_rate);
    for (const auto& u : problem_.unknowns)
      if (u.impulse_n > 0) responses.push(place(u.normal), u.impulse_n, s.q.data());
    place_end(s);
    return;
  }
  const double before = deepest(s, contacts);
  compromise(s, responses);
  move(s, s.dq);
  place_end(s);
  look(s, contacts);
  const double after = deepest(s, contacts);
  report(s, -std::max(before, after));
  if (!(after >= before)) {
    for (int i = 0; i < s.system.n(); ++i) s.q[i] -= s.dq[i];
    place_end(s);
  }
}

/// Reports a correction whose gaps are this far (m) from its solution, unless this is rounding.
void PositionCorrection::report(StepData& s, double residual) {
  if (!(residual > rounding_of_places(s))) return;
  auto& found = s.totals.found;
  ++found.uncorrected;
  found.residual = std::max(found.residual, residual);
}

ContactSolution PositionCorrection::solve(const ImpulseResponses& responses) {
  if (islands_) {
    islands_->clear();
    return islands_->solve(problem_, place_, id_, responses.rows(), responses.sparse());
  }
  auto& D = problem_.D;
  for (int r = 0; r < problem_.rows; ++r)
    for (int c = 0; c <= r; ++c) D(r, c) = D(c, r) = responses.row(r).dot(responses.response(c));
  return problem_.solve();
}

/// Computes dq for a position problem without solution: a row of bodies that just fits between two
/// walls can require, by rounding, more space than there is. Sweeps find the least overlaps; the
/// rest appears in the run's greatest penetration.
void PositionCorrection::compromise(StepData& s, const ImpulseResponses& responses) {
  constexpr int sweeps = 200;
  std::ranges::fill(s.dq, 0.0);
  for (auto& u : problem_.unknowns) u.impulse_n = 0;
  for (int sweep = 0; sweep < sweeps; ++sweep)
    for (auto& u : problem_.unknowns) {
      const int at = place(u.normal);
      const double mobility = responses.along(responses.row(at), at);
      if (!(mobility > 0)) continue;
      const double gap = problem_.b[u.normal] + responses.row(at).dot(s.dq.data());
      const double by = std::max(-u.impulse_n, -gap / mobility);
      u.impulse_n += by;
      responses.push(at, by, s.dq.data());
    }
}

/// Pressed contacts drift apart by a third-order error, as they drift together. They are moved back
/// one by one, which is sufficient for gaps that are a small part of the tolerance.
void PositionCorrection::draw_closed(StepData& s, ContactSet& contacts, const StepProblem& problem,
                                     ImpulseResponses& responses) {
  for (int k = 0; k < s.system.contacts(); ++k) {
    auto& c = contacts[k];
    const auto* u = problem.unknown_of(c);
    if (!c.closed || !u || !(u->impulse_n > 0)) continue;
    c.gap = s.system.gap(k, s.q.data(), s.end);
    if (!(c.gap > 0.01 * contacts.slack)) continue;
    if (islands_) {
      const int place = responses.first(k);
      responses.row(place) = c.row.normal;
      responses.respond(s.saddle, place);
      responses.push(place, -c.gap / responses.along(c.row.normal, place), s.q.data());
    } else {
      s.saddle.respond(c.row.normal, nullptr, 0, s.dq.data(), s.dlambda.data(), Multipliers::kept);
      const double by = c.gap / c.row.normal.dot(s.dq.data());
      for (int i = 0; i < s.system.n(); ++i) s.q[i] -= by * s.dq[i];
    }
    s.system.place(s.t, s.q.data(), s.end);
    c.gap = s.system.gap(k, s.q.data(), s.end);
  }
}

}  // namespace freeplay
