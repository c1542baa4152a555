#include "formulations/event_driven/event_dynamics.hpp"

#include <algorithm>

namespace freeplay {

double ModeProjection::project(ModeEquations& d, std::vector<double>& x, double t, Forces* impulses) {
  const auto& system = d.system;
  const int m = system.rows();
  double* q = x.data();
  double* v = q + system.n();
  const double before = system.kinetic(v) + system.potential(q);
  residual_.resize(static_cast<std::size_t>(m));
  change_.resize(static_cast<std::size_t>(system.n()));
  d.place(q, t);
  ++d.work.factorisations;
  if (!d.saddle.factor(d.e.G.data())) return 0;
  for (int k = 0; k < m; ++k) residual_[k] = -d.e.phi[k];
  hold_positions(d, q, v);
  move(d, q);
  d.place(q, t);
  for (int k = 0; k < m; ++k) residual_[k] = -(row_dot(system.pattern(), d.e.G.data(), k, v) + d.e.phi_t[k]);
  hold_velocities(d, q, v);
  move(d, v);
  if (impulses) enter(d, q, v, *impulses);
  return system.kinetic(v) + system.potential(q) - before;
}

void ModeProjection::move(ModeEquations& d, double* y) {
  const int n = d.system.n();
  auto& rows = d.rows;
  d.saddle.solve(nullptr, residual_.data(), change_.data(), d.lambda.data());
  if (rows.used() > 0) {
    for (int r = 0; r < rows.used(); ++r) rows.b[r] = -rows.b[r] - rows.row(r).dot(change_.data());
    rows.fill_symmetric();
    rows.solve();
    for (int r = 0; r < rows.used(); ++r) {
      const double force = rows.x[r];
      const double* response = rows.response(r);
      for (int i = 0; i < n; ++i) change_[i] += force * response[i];
    }
  }
  for (int i = 0; i < n; ++i) y[i] += change_[i];
}

void ModeProjection::hold_positions(ModeEquations& d, const double* q, const double* v) {
  d.rows.clear();
  for (int k = 0; k < d.system.contacts(); ++k) {
    auto& c = d.contacts[k];
    if (!c.closed && !c.resting) continue;
    d.system.contact(k, q, v, d.e, c.row);
    // A contact that has separated is open like others.
    if (c.row.gap > d.closed_gap(k, q)) c.resting = false;
    const bool stays = c.resting && c.row.normal.dot(v) <= d.speed_tolerance();
    if (c.closed || stays || c.row.gap < 0) {
      const int r = d.add(c.row.normal);
      d.rows.b[r] = c.row.gap;
    }
  }
}

void ModeProjection::hold_velocities(ModeEquations& d, const double* q, const double* v) {
  d.rows.clear();
  owners_.clear();
  const auto want = [&](const SparseRow& row, Owner owner) {
    const int r = d.add(row);
    d.rows.b[r] = row.dot(v);
    owners_.push_back(owner);
  };
  for (int k = 0; k < d.system.contacts(); ++k) {
    auto& c = d.contacts[k];
    if (!c.closed && !c.resting) continue;
    d.system.contact(k, q, v, d.e, c.row);
    if (c.closed || c.row.normal.dot(v) <= d.speed_tolerance()) want(c.row.normal, {k, -1, false});
    if (c.closed && c.slip == 0 && c.row.tangent.size > 0) want(c.row.tangent, {k, -1, true});
  }
  for (int k = 0; k < d.system.frictions(); ++k) {
    if (d.preloaded[k].slip != 0) continue;
    d.system.friction(k, q, v, d.e, d.preloaded[k].row);
    want(d.preloaded[k].row, {-1, k, true});
  }
}

void ModeProjection::enter(ModeEquations& d, const double* q, const double* v, Forces& impulses) const {
  const auto& system = d.system;
  const auto& rows = d.rows;
  for (int r = 0; r < rows.used(); ++r) {
    for (int k = 0; k < system.rows(); ++k) d.lambda[k] += rows.x[r] * rows.reaction(r)[k];
    const auto& o = owners_[r];
    if (o.contact >= 0)
      system.report().contact(o.contact, q, d.e, d.contacts[o.contact].row, o.tangent ? 0 : rows.x[r],
                              o.tangent ? rows.x[r] : 0, 1, impulses);
    else
      system.report().friction(o.friction, q, v, d.e, rows.row(r), rows.x[r], 1, impulses);
  }
  system.report().rows(system.pattern(), q, d.e, d.lambda.data(), 1, impulses);
  for (int i = 0; i < system.n(); ++i) impulses.acceleration[i] += change_[i];
}

EventDynamics::EventDynamics(const System& s, const NonsmoothOptions& options,
                             const std::vector<double>& restitution, RowFacts facts, double speed_scale)
    : ModeEquations(s, restitution, facts, speed_scale),
      options_(options),
      choice_(options, coupled.size()),
      impact_(options, *this) {}

void EventDynamics::rate(const Vector& x, Vector& dxdt, double t, bool compiled) {
  t = std::min(t, knot);
  const int n = system.n(), m = system.rows();
  const double* v = x.data() + n;
  ModeMotion::Compiled known{};
  compiled = compiled && motion_.solve_compiled(*this, x, t, known);
  if (!compiled && !motion_.solve(*this, x, t)) {
    std::ranges::fill(dxdt, __builtin_nan(""));  // the step is rejected
    return;
  }
  std::copy(v, v + n, dxdt.begin());
  std::ranges::copy(a, dxdt.begin() + n);
  double* integral = dxdt.data() + integral_offset();
  integral[drive] = e.power.drive;
  integral[load] = e.power.load;
  integral[damping] = -e.power.damping;
  integral[friction_loss] = 0;
  if (films.any()) integral[film_loss] = films.loss();
  if (compiled)
    integral[drive] = known.drive;
  else
    for (int k = 0; k < m; ++k) integral[drive] += lambda[k] * e.phi_t[k];
  if (system.states() > 0)
    system.flow(t, x.data(), v, x.data() + state_offset(), dxdt.data() + state_offset(),
                {nullptr, phases.pieces()});
  double* impulse = dxdt.data() + impulse_offset();
  for (const auto& c : contacts) {
    *impulse++ = c.lambda_n;
    *impulse++ = c.lambda_t;
    if (c.lambda_t != 0)
      integral[friction_loss] -= c.lambda_t * (compiled ? known.sliding : c.row.tangent.dot(v));
  }
  for (const auto& p : preloaded) integral[friction_loss] -= p.lambda * p.rate;
}

void EventDynamics::report(const Vector& x, double t, Forces& out) {
  t = std::min(t, knot);
  const double *q = x.data(), *v = q + system.n();
  out.clear();
  if (!motion_.solve_for_report(*this, x, t)) return void(++counts.unreported);
  std::ranges::copy(a, out.acceleration.begin());
  system.report().rows(system.pattern(), q, e, lambda.data(), 1, out);
  for (int k = 0; k < system.contacts(); ++k) {
    const auto& c = contacts[k];
    if (c.closed) system.report().contact(k, q, e, c.row, c.lambda_n, c.lambda_t, 1, out);
  }
  films.report(system, q, v, e, out);
  for (int k = 0; k < system.frictions(); ++k)
    system.report().friction(k, q, v, e, preloaded[k].row, preloaded[k].lambda, 1, out);
  system.report().loads(t, q, v, x.data() + state_offset(), e, 1, out, {nullptr, phases.pieces()});
}

double EventDynamics::gap_acceleration(int k, const Vector& x, double t) {
  if (!motion_.solve(*this, x, t)) return 0;
  auto& row = contacts[k].row;
  system.contact(k, x.data(), x.data() + system.n(), e, row);
  return row.normal.dot(a.data()) - row.gamma_n;
}

std::string EventDynamics::apply_impact(Vector& x, double t, const ImpactEquations::Impact& impact) {
  if (auto reason = impact_.solve(*this, x, t, impact); !reason.empty()) return reason;
  double* integral = x.data() + integral_offset();
  impact_.apply(*this, x, impact.contacts, integral[drive]);
  contact_loss -= impact_.normal_work();
  integral[friction_loss] -= impact_.tangential_work();
  return "";
}

std::unique_ptr<EventDynamics> EventDynamics::twin() const {
  std::vector<double> restitution;
  for (const auto& c : contacts) restitution.push_back(c.restitution);
  auto other = std::make_unique<EventDynamics>(system, options_, restitution, facts(), speed_scale());
  other->phases = phases;
  return other;
}

std::unique_ptr<EventDynamics> EventDynamics::twin_of(const System& displaced) const {
  std::vector<double> restitution;
  for (int k = 0; k < displaced.contacts(); ++k)
    restitution.push_back(displaced.contact_facts(k).surface.slow_restitution().value_or(0));
  auto other = std::make_unique<EventDynamics>(displaced, options_, restitution, facts(), speed_scale());
  other->phases = phases;
  return other;
}

void EventDynamics::take_mode(const Vector& x, std::span<const signed char> modes) {
  const auto slip = [&](std::size_t i) { return modes[i] == 2 ? 1 : modes[i] == 3 ? -1 : 0; };
  for (std::size_t k = 0; k < contacts.size(); ++k) {
    contacts[k].closed = modes[k] != 0;
    contacts[k].slip = slip(k);
    contacts[k].resting = false;
  }
  for (std::size_t k = 0; k < preloaded.size(); ++k) preloaded[k].slip = slip(contacts.size() + k);
  motion_.begin_mode();
  phases.start(system, x.data(), x.data() + system.n());
  forget_place();
}

void EventDynamics::take_mode(const EventDynamics& other) {
  for (std::size_t k = 0; k < contacts.size(); ++k) {
    contacts[k].closed = other.contacts[k].closed;
    contacts[k].slip = other.contacts[k].slip;
    contacts[k].resting = other.contacts[k].resting;
    contacts[k].lambda_n = other.contacts[k].lambda_n;
    contacts[k].lambda_t = other.contacts[k].lambda_t;
  }
  motion_.begin_mode();
  phases = other.phases;
  forget_place();
  knot = other.knot;
  for (std::size_t k = 0; k < preloaded.size(); ++k) {
    preloaded[k].slip = other.preloaded[k].slip;
    preloaded[k].reaction = other.preloaded[k].reaction;
  }
}

}  // namespace freeplay
