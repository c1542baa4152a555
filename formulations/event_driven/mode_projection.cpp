#include "formulations/event_driven/mode_projection.hpp"

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
      system.report_contact(o.contact, q, d.e, d.contacts[o.contact].row, o.tangent ? 0 : rows.x[r],
                            o.tangent ? rows.x[r] : 0, 1, impulses);
    else
      system.report_friction(o.friction, q, v, d.e, rows.row(r), rows.x[r], 1, impulses);
  }
  system.report_rows(q, d.e, d.lambda.data(), 1, impulses);
  for (int i = 0; i < system.n(); ++i) impulses.acceleration[i] += change_[i];
}

}  // namespace freeplay
