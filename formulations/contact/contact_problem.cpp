#include "formulations/contact/contact_problem.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace freeplay {

void ContactSolution::count(Work& work, Extremes& extremes) const {
  work.pivots += pivots;
  work.lcp_retries += retries;
  extremes.lcp_residual = std::max(extremes.lcp_residual, residual);
  extremes.lcp_residual_rate = std::max(extremes.lcp_residual_rate, residual_rate);
  extremes.ambiguous += ambiguous;
}

void ContactProblem::reserve(int size) {
  if (size <= D.rows()) return;
  ContactEquations::reserve(size);
  room_.last.reserve(static_cast<std::size_t>(size));
  room_.rates.setZero(size);
  room_.factor.setZero(size, size);
}

void ContactProblem::reserve_rates(int size) {
  ContactEquations::reserve_rates(size);
  room_.last.reserve(static_cast<std::size_t>(size));
}

/// The solvers to try, in this order: the named one or, if none is named, the cheapest for the size
/// of the problem; then the others of Lemke's method, Newton's method and mixed sweeps.
std::array<Solver*, 4> ContactProblem::order() const {
  const auto n = static_cast<int>(unknowns.size());
  if (n == 1 && singular_pair(*this, unknowns.front()))
    // which impulses to take is decided by a rule, not by a solver
    return {closed_form, lemke, newton, nullptr};
  Solver* first = named_solver(solver_);
  if (first == enumeration && n > most_for_enumeration) first = lemke;
  if (!first)
    first = n == 1 ? closed_form : n == 2 ? enumeration : n <= most_for_lemke ? lemke : mixed_gauss_seidel;
  std::array<Solver*, 4> order{first};
  const bool swept = first == closed_form || first == gauss_seidel;  // further sweeps gain nothing
  std::size_t next = 1;
  for (Solver* other : {lemke, newton, mixed_gauss_seidel})
    if (other != first && !(swept && other == mixed_gauss_seidel)) order[next++] = other;
  return order;
}

/// Sets the residuals of the present impulses.
void ContactProblem::finish(ContactSolution& s, double size) const {
  s.residual_rate = residual();
  s.residual = size > 0 ? s.residual_rate / size : s.residual_rate;
}

/// A single unknown whose closed form holds: the way of solve() in this case. Returns false if that
/// must look further.
bool ContactProblem::alone(ContactSolution& s, double size) {
  auto& c = unknowns.front();
  const int n = c.normal, t = c.tangent;
  const bool least_known = least == Least::never || least == Least::where_singular;
  if (n < 0 || t < 0 || solver_ != LcpSolver::automatic || !least_known) return false;
  const double nn = D(n, n), nt = D(n, t), tt = D(t, t), bn = b[n], bt = b[t];
  if (singular_pair(*this, c) || !solve_one(c, bn, bt, nn, nt, tt)) return false;
  const double Pn = c.impulse_n, Pt = c.impulse_t;
  if (!std::isfinite(Pn) || !std::isfinite(Pt)) return false;
  s.residual_rate = contact_residual(
      unknowns,
      [&](std::size_t) {
        return RowState{bn + nn * Pn + nt * Pt, nn, Pn};
      },
      [&](std::size_t) {
        return RowState{bt + D(t, n) * Pn + tt * Pt, tt, Pt};
      });
  if (!std::isfinite(s.residual_rate) ||
      !(s.residual_rate <= tolerance_ * size || s.residual_rate <= attainable()))
    return false;
  s.pivots = SolverSummary{}.iterations;
  s.residual = size > 0 ? s.residual_rate / size : s.residual_rate;
  if (Pn > 0 && nn <= c.friction * std::abs(nt)) look_for_others(s);
  return true;
}

ContactSolution ContactProblem::solve() {
  ContactSolution s;
  if (unknowns.empty()) return s;
  const double size = std::max(scale(), least_scale), accepted = tolerance_ * size;
  if (unknowns.size() == 1) {
    if (alone(s, size)) return s;
    s = {};
  }
  s.solved = false;
  if (static_cast<int>(unknowns.size()) > most_for_lemke && solver_ == LcpSolver::automatic &&
      by_islands(s)) {
    if (s.solved && wants_least(least, *this, room_)) take_least(*this, accepted, true);
    finish(s, size);
    return s;
  }
  // Rounding may keep all solvers from the tolerance. The best result is then accepted, up to this
  // relative residual.
  constexpr double loosest = 1e-6;
  std::vector<ContactUnknown> best;
  double best_rate = loosest * size;
  bool assessed = false;  // whether residual_rate belongs to the present impulses
  const auto keep = [&] {
    const double left = residual();
    if (!(left < best_rate)) return;
    best_rate = left;
    best = unknowns;
  };
  for (Solver* solver : order()) {
    if (!solver) break;
    for (auto& c : unknowns)  // discard the impulses of a solver that failed
      if (s.retries > 0) c.impulse_n = c.impulse_t = 0;
    const auto found = solver(*this, accepted, room_);
    s.pivots += found.iterations;
    s.residual_rate = residual();
    s.solved = found.solved && std::isfinite(s.residual_rate) &&
               (s.residual_rate <= accepted || s.residual_rate <= attainable());
    if (s.solved) {
      assessed = true;
      break;
    }
    keep();
    ++s.retries;
  }
  for (const auto last_resort : {copositive_lemke, proximal}) {
    if (s.solved || unknowns.size() == 1) break;
    const auto found = last_resort(*this, accepted, room_);
    s.pivots += found.iterations;
    s.solved = found.solved;
    keep();
  }
  if (!s.solved && !best.empty()) {
    unknowns = best;
    s.solved = true;
  }
  s.solved = s.solved || (std::isfinite(size) && finite() && by_modes(s));
  if (least != Least::never && std::isfinite(size) && finite() && wants_least(least, *this, room_)) {
    s.solved = take_least(*this, accepted, s.solved) || s.solved;
    assessed = false;
  }
  if (!assessed) s.residual_rate = residual();
  s.residual = size > 0 ? s.residual_rate / size : s.residual_rate;
  if (s.solved && doubtful()) look_for_others(s);
  return s;
}

/// Determines whether friction admits motions other than the present one.
void ContactProblem::look_for_others(ContactSolution& s) {
  std::vector<std::vector<int>> members;
  for (const auto& m : doubtful_motions(*this, modes_left, members)) {
    s.ambiguous |= m.decided && m.motions.size() > 1;
    s.undecided |= !m.decided;
    modes_left -= m.tried;
  }
}

/// Solves each island separately; returns false if there is only one.
bool ContactProblem::by_islands(ContactSolution& s) {
  std::vector<int> label, members;
  const int islands = label_islands(label);
  if (islands < 2) return false;
  s.solved = true;
  for (int k = 0; k < islands; ++k) {
    ContactProblem part(solver_, tolerance_);
    static_cast<ContactEquations&>(part) = island(label, k, members);
    part.modes_left = modes_left;
    const auto one = part.solve();
    modes_left = part.modes_left;
    s.solved = s.solved && one.solved;
    s.ambiguous |= one.ambiguous;
    s.undecided |= one.undecided;
    s.impossible |= one.impossible;
    s.pivots += one.pivots;
    s.retries += one.retries;
    take_impulses(part, members);
  }
  return true;
}

/// Tries all modes, if they are few enough: takes the first consistent one, or finds that there is
/// none.
bool ContactProblem::by_modes(ContactSolution& s) {
  const auto all = modes(1);
  modes_left -= all.tried;
  s.pivots += static_cast<int>(all.tried);
  s.impossible = all.decided && all.motions.empty();
  if (all.motions.empty()) return false;
  for (auto& c : unknowns) {
    c.impulse_n = c.normal >= 0 ? all.motions[0].impulses[c.normal] : 0;
    c.impulse_t = c.tangent >= 0 ? all.motions[0].impulses[c.tangent] : 0;
  }
  return true;
}

}  // namespace freeplay
