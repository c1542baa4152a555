#include "formulations/time_stepping/end_rates.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace freeplay {
namespace {

bool sticks(const ContactUnknown& u, double bound) {
  return u.tangent >= 0 && std::abs(u.impulse_t) < bound * (1 - 1e-9);
}

}  // namespace

EndRates::EndRates(const System& system, int rows)
    : rows_(static_cast<std::size_t>(rows)), v_(system.n()), lambda_(system.rows()) {}

/// Calls visit(k, unknown, whether it sticks) for every contact with an impulse in the step; its
/// rows at the end are in row_.
template <class Visit>
void EndRates::each_pressed(const StepData& s, const ContactSet& contacts, const StepProblem& problem,
                            Visit visit) {
  for (int k = 0; k < s.system.contacts(); ++k) {
    const auto& c = contacts[k];
    const auto* u = problem.unknown_of(c);
    if (!c.closed || !u || !(u->impulse_n > 0)) continue;
    visit(k, *u, sticks(*u, u->friction * u->impulse_n));
  }
}

template <class Visit>
void EndRates::each_sticking_joint(const StepData& s, const StepProblem& problem, Visit visit) {
  for (int k = 0; k < s.system.frictions(); ++k) {
    const auto& u = problem.friction(k);
    if (sticks(u, u.bound) && !problem.driven(k)) visit(k);
  }
}

void EndRates::take(ImpulseResponses& responses, const SparseRow& row, double least) {
  auto& x = rows_[used_];
  x.least = least;
  x.slope = 0;
  x.held = -1;
  responses.row(used_++) = row;
}

void EndRates::collect(StepData& s, const ContactSet& contacts, const StepProblem& problem,
                       ImpulseResponses& responses) {
  used_ = 0;
  each_pressed(s, contacts, problem, [&](int k, const ContactUnknown& u, bool stuck) {
    s.system.contact(k, s.q.data(), s.v.data(), s.end, row_);
    take(responses, row_.normal, -u.impulse_n);
    if (stuck) {
      take(responses, row_.tangent, -INFINITY);
      rows_[used_ - 1].held = contacts[k].unknown;
    } else if (u.tangent >= 0) {
      rows_[used_ - 1].slope = u.impulse_t / u.impulse_n;
      rows_[used_ - 1].beside = row_.tangent;
    }
  });
  each_sticking_joint(s, problem, [&](int k) {
    s.system.friction(k, s.q.data(), s.v.data(), s.end, row_.tangent);
    take(responses, row_.tangent, -INFINITY);
  });
}

void EndRates::respond(StepData& s, ImpulseResponses& responses) {
  for (int r = 0; r < used_; ++r) {
    auto& x = rows_[r];
    responses.respond(s.saddle, r, &x.beside, x.slope);
    // friction that pulls the contact closed (Painlevé)
    if (!(responses.along(responses.row(r), r) > 0)) {
      x.slope = 0;
      responses.respond(s.saddle, r, nullptr, 0);
    }
    x.impulse = 0;
  }
}

/// Gauss–Seidel over the rows, which may depend on each other. Returns false if friction impulses
/// amplify each other from sweep to sweep.
bool EndRates::sweep(StepData& s, const StepProblem& problem, const ImpulseResponses& responses) {
  double first = 0, begun = 0, most = 0;
  for (int sweep = 0; sweep < (used_ > 1 ? 20 : 1); ++sweep) {
    most = 0;
    for (int r = 0; r < used_; ++r) {
      auto& x = rows_[r];
      const double rate = responses.row(r).dot(s.v.data()), d = responses.along(responses.row(r), r);
      if (!(d > 0)) continue;
      // The impulse of a contact is reduced at most to zero. A contact that then still separates
      // does so, and friction no longer holds it.
      double impulse = std::max(x.impulse - rate / d, x.least);
      if (x.held >= 0) {
        const auto& u = problem.problem.unknowns[static_cast<std::size_t>(x.held)];
        const double bound = u.friction * std::max(0.0, u.impulse_n + rows_[r - 1].impulse);
        impulse = std::clamp(impulse, -bound - u.impulse_t, bound - u.impulse_t);
      }
      const double by = impulse - x.impulse;
      most = std::max(most, std::abs(by) * d);
      x.impulse = impulse;
      responses.push(r, by, s.v.data());
    }
    first = std::max(first, most);
    if (sweep == 0) begun = most;
    if (!(most > 1e-6 * first)) return true;
  }
  return !(most > begun);
}

void EndRates::find_impulses(StepData& s, const StepProblem& problem, ImpulseResponses& responses) {
  v_ = s.v;
  if (sweep(s, problem, responses)) return;
  // Without friction impulses the problem is symmetric and sweeps converge.
  s.v = v_;
  for (int r = 0; r < used_; ++r) {
    rows_[r].impulse = rows_[r].slope = 0;
    responses.respond(s.saddle, r, nullptr, 0);
  }
  sweep(s, problem, responses);
}

bool EndRates::meet(StepData& s, ContactSet& contacts, const StepProblem& problem,
                    ImpulseResponses& responses, StepForces& forces) {
  const int n = s.system.n(), m = s.system.rows();
  collect(s, contacts, problem, responses);
  if (m == 0 && used_ == 0) return true;
  ++s.totals.work.factorisations;
  if (!s.saddle.factor(s.end.G.data()))
    return s.fail(
        fmt::format("t = {:.9g} s: the constraint equations are not finite or cannot be factorised", s.t));
  const double before = s.system.kinetic(s.v.data());
  for (int k = 0; k < m; ++k)
    s.r[k] = -s.end.phi_t[k] - row_dot(s.system.pattern(), s.end.G.data(), k, s.v.data());
  s.saddle.solve(nullptr, s.r.data(), s.dq.data(), s.dlambda.data());
  respond(s, responses);
  for (int i = 0; i < n; ++i) s.v[i] += s.dq[i];
  find_impulses(s, problem, responses);
  double rubbed = 0;
  each_pressed(s, contacts, problem, [&, r = 0](int k, const ContactUnknown&, bool stuck) mutable {
    const auto& x = rows_[r];
    const double tangential = x.slope * x.impulse;
    if (x.slope != 0) rubbed += tangential * x.beside.dot(s.v.data());
    ++r;
    contacts[k].impulse_n += x.impulse;
    contacts[k].impulse_t += stuck ? rows_[r++].impulse : tangential;
  });
  auto& integrals = s.totals.integrals;
  integrals.friction -= rubbed;
  // Ideal joints do no work, so this work is assigned to the drives (accumulate_energies()).
  (s.system.drive_rows() > 0 ? integrals.drive : integrals.stabilisation) +=
      s.system.kinetic(s.v.data()) - before - rubbed;
  if (forces.watching()) report(s, contacts, problem, responses, forces.smooth());
  return true;
}

void EndRates::report(StepData& s, const ContactSet& contacts, const StepProblem& problem,
                      ImpulseResponses& responses, Forces& out) {
  const int n = s.system.n(), m = s.system.rows();
  const double *q = s.q.data(), *v = s.v.data();
  for (int i = 0; i < n; ++i) out.acceleration[i] += s.dq[i];
  for (int r = 0; r < used_; ++r) responses.push(r, rows_[r].impulse, out.acceleration.data());
  if (responses.many()) {
    std::ranges::fill(s.force, 0.0);
    for (int r = 0; r < used_; ++r) {
      responses.row(r).add_to(s.force.data(), rows_[r].impulse);
      rows_[r].beside.add_to(s.force.data(), rows_[r].impulse * rows_[r].slope);
    }
    s.saddle.solve(s.force.data(), nullptr, s.dq.data(), lambda_.data());
    for (int k = 0; k < m; ++k) s.dlambda[k] += lambda_[k];
  } else {
    for (int r = 0; r < used_; ++r)
      for (int k = 0; k < m; ++k) s.dlambda[k] += rows_[r].impulse * responses.reaction(r)[k];
  }
  s.system.report().rows(s.system.pattern(), q, s.end, s.dlambda.data(), 1, out);
  int r = 0;
  each_pressed(s, contacts, problem, [&](int k, const ContactUnknown&, bool stuck) {
    s.system.contact(k, q, v, s.end, row_);
    const double normal = rows_[r].impulse, tangential = rows_[r].slope * normal;
    ++r;
    s.system.report().contact(k, q, s.end, row_, normal, stuck ? rows_[r++].impulse : tangential, 1, out);
  });
  each_sticking_joint(s, problem, [&](int k) {
    s.system.friction(k, q, v, s.end, row_.tangent);
    s.system.report().friction(k, q, v, s.end, row_.tangent, rows_[r++].impulse, 1, out);
  });
}

}  // namespace freeplay
