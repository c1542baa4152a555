#include "formulations/event_driven/impact_equations.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "formulations/contact/contact_law.hpp"

namespace freeplay {

ImpactEquations::ImpactEquations(const NonsmoothOptions& options, const ModeEquations& d)
    : impact_(options.impact_law, options.solver, options.lcp_tolerance), lambda_(d.lambda.size()) {
  for (int i = 0; i < d.coupled.size(); ++i)  // a fixed bound gives no impulse to an instant
    if (d.bound_of(i).reads_reactions()) reacting_.push_back(i);
  image_.setZero(static_cast<Eigen::Index>(reacting_.size()));
  for (int k = 0; k < d.system.contacts(); ++k)
    ratio_.push_back(options.impact_law == ImpactLaw::compliant &&
                             d.system.contact_facts(k).surface.friction.value_or(0) > 0
                         ? stiffness_ratio(d.system.contact_facts(k).surface)
                         : 1);
}

std::string ImpactEquations::solve(ModeEquations& d, const Vector& x, double t, const Impact& impact) {
  d.place(x.data(), t);
  ++d.work.factorisations;
  ++d.work.lcp_solves;
  if (!d.saddle.factor(d.e.G.data())) return "the constraint equations cannot be factorised";
  pose(d, x, impact);
  d.rows.fill_symmetric();
  if (impact.without_collision) press(d);
  auto& rows = d.rows;
  const auto reason = !reacting_.empty() ? solve_bounded(d, x.data() + d.system.n(), impact.contacts.size())
                                         : impact_.solve(rows.K, rows.b, rows.used(), in_impact_);
  impact_.solution().count(d.work, d.extremes);
  d.counts.undecided += impact_.solution().undecided;
  d.counts.wedged += impact_.wedged();
  if (!reason.empty()) return reason;
  for (const auto& i : in_impact_)
    if (!std::isfinite(i.impulse_n) || !std::isfinite(i.impulse_t))
      return fmt::format("no solver found finite impulses for the impact of {} contacts", in_impact_.size());
  // A rate within the residual of the solver is no approach.
  d.raise_speed_tolerance(2 * impact_.solution().residual_rate);
  return "";
}

void ImpactEquations::pose(ModeEquations& d, const Vector& x, const Impact& impact) {
  const double *q = x.data(), *v = q + d.system.n();
  d.rows.clear();
  in_impact_.clear();
  const auto add = [&](const SparseRow& row) {
    const int r = d.add(row);
    d.rows.b[r] = row.dot(v);
    return r;
  };
  for (const int k : impact.contacts) {
    auto& c = d.contacts[k];
    d.system.contact(k, q, v, d.e, c.row);
    ImpactContact i;
    i.normal = add(c.row.normal);
    const bool inelastic = std::ranges::find(impact.inelastic, k) != impact.inelastic.end();
    i.restitution = inelastic    ? 0
                    : c.by_speed ? c.by_speed->restitution_at(-d.rows.b[i.normal])
                                 : c.restitution;
    if (c.row.tangent.size > 0) {
      const auto& surface = d.system.contact_facts(k).surface;
      i.tangent = add(c.row.tangent);
      i.friction = surface.friction_at(d.rows.b[i.tangent]);  // of the sliding before the impact
      i.tangential_restitution = inelastic ? 0 : surface.tangential_restitution;
      i.stiffness_ratio = ratio_[static_cast<std::size_t>(k)];
    }
    in_impact_.push_back(i);
  }
  for (const int i : reacting_) {
    auto& p = d.preloaded[d.coupled.friction(i)];
    d.system.friction(d.coupled.friction(i), q, v, d.e, p.row);
    ImpactContact pin;
    pin.tangent = add(p.row);
    in_impact_.push_back(pin);
  }
}

/// Rates of an impact without collision. Closed contacts get an approach rate as small as is
/// significant compared with the sliding speed to be stopped; contacts that separate faster keep
/// their rates. If contacts share freedoms, the rates are replaced by the nearest rates of an
/// actual motion, because for other rates the laws need not have a solution (contact/solvers.cpp).
void ImpactEquations::press(ModeEquations& d) {
  auto& rows = d.rows;
  auto rates = rows.b.head(rows.used());
  pressing_rate_ = std::max(d.speed_tolerance(), 1e-5 * rates.cwiseAbs().maxCoeff());
  Eigen::VectorXd pressed = rates;
  for (const auto& i : in_impact_)
    if (i.normal >= 0 && rates[i.normal] <= pressing_rate_)
      pressed[i.normal] = std::min(0.0, rates[i.normal]) - pressing_rate_;
  const auto K = rows.K.topLeftCorner(rows.used(), rows.used());
  if (const MinimumNorm decomposition(K, 1e-10); decomposition.rank() < rows.used())
    pressed = rates + K * decomposition.solve(pressed - rates);
  rates = pressed;
}

/// Decouples the rows that no impulse moves, of joints with prescribed motion. Returns for each
/// such row its mobility without constraints; 0 for the others.
std::vector<double> ImpactEquations::pose_driven(ModeEquations& d, std::size_t contacts) {
  auto& rows = d.rows;
  std::vector<double> driven(reacting_.size());
  for (std::size_t i = 0; i < driven.size(); ++i) {
    const int own = in_impact_[contacts + i].tangent;
    const double free = d.unconstrained_mobility(rows.row(own));
    if (std::abs(rows.K(own, own)) > 1e-12 * free) continue;
    driven[i] = free;
    for (int r = 0; r < rows.used(); ++r) rows.K(r, own) = rows.K(own, r) = 0;
  }
  return driven;
}

/// Mean of the sliding speeds of a joint before and after the impact.
double ImpactEquations::mean_rate(const ModeEquations& d, int own, bool driven, const double* v) const {
  double mean = d.rows.row(own).dot(v);
  for (const auto& c : in_impact_)
    for (const auto& [row, impulse] : {std::pair{c.normal, c.impulse_n}, std::pair{c.tangent, c.impulse_t}})
      if (row >= 0 && (row != own || !driven)) mean += 0.5 * d.rows.K(own, row) * impulse;
  return mean;
}

/// Solves the impact with friction in joints whose bounds depend on their own reaction impulses.
std::string ImpactEquations::solve_bounded(ModeEquations& d, const double* v, std::size_t contacts) {
  auto& rows = d.rows;
  image_.setZero();
  bounds_.start(image_);
  const auto driven = pose_driven(d, contacts);
  do {
    for (std::size_t i = 0; i < driven.size(); ++i) {
      auto& joint = in_impact_[contacts + i];
      joint.bound = bounds_.bounds()[static_cast<Eigen::Index>(i)];
      if (driven[i] == 0) continue;
      const double rate = std::abs(rows.b[joint.tangent]);
      rows.K(joint.tangent, joint.tangent) =
          rate > 0 && joint.bound > 0 ? 0.5 * rate / joint.bound : driven[i];
    }
    if (auto reason = impact_.solve(rows.K, rows.b, rows.used(), in_impact_); !reason.empty()) return reason;
    for (std::size_t i = 0; i < driven.size(); ++i) {
      const auto& bound = d.bound_of(reacting_[i]);
      ReactionBound::Reactions l{};
      for (const auto& c : in_impact_)
        for (const auto& [row, impulse] :
             {std::pair{c.normal, c.impulse_n}, std::pair{c.tangent, c.impulse_t}})
          if (row >= 0) {
            const auto by = bound.reactions(rows.reaction(row));
            for (const std::size_t which : {0U, 1U}) l[which] += impulse * by[which];
          }
      const auto& own = in_impact_[contacts + i];
      const double mean = mean_rate(d, own.tangent, driven[i] != 0, v);
      const double side = own.impulse_t != 0 ? own.impulse_t : -rows.b[own.tangent];
      image_[static_cast<Eigen::Index>(i)] = bound.coefficient(mean) * bound.support(l, side);
    }
  } while (bounds_.refine(image_));
  d.extremes.friction_residual = std::max(d.extremes.friction_residual, bounds_.residual());
  return bounds_.met() ? ""
                       : fmt::format("within an impact {}; bounds and reactions differ by {:.2g}, relative",
                                     words_of(CoupledFriction::Outcome::none), bounds_.residual());
}

void ImpactEquations::apply(ModeEquations& d, Vector& x, const std::vector<int>& contacts, double& drive) {
  const int n = d.system.n(), m = d.system.rows();
  double* v = x.data() + n;
  std::ranges::fill(lambda_, 0.0);
  const auto take = [&](int r, double impulse) {
    if (r < 0) return;
    for (int i = 0; i < n; ++i) v[i] += impulse * d.rows.response(r)[i];
    for (int k = 0; k < m; ++k) {
      drive += impulse * d.rows.reaction(r)[k] * d.e.phi_t[k];
      lambda_[k] += impulse * d.rows.reaction(r)[k];
    }
  };
  for (std::size_t i = 0; i < in_impact_.size(); ++i) {
    take(in_impact_[i].normal, in_impact_[i].impulse_n);
    take(in_impact_[i].tangent, in_impact_[i].impulse_t);
    if (i >= contacts.size()) continue;
    double* impulse = x.data() + d.impulse_offset() + 2 * contacts[i];
    impulse[0] += in_impact_[i].impulse_n;
    impulse[1] += in_impact_[i].impulse_t;
  }
}

void ImpactEquations::report(ModeEquations& d, const Vector& x, const std::vector<int>& contacts,
                             Forces& out) const {
  const double* q = x.data();
  out.clear();
  d.system.report().rows(d.system.pattern(), q, d.e, lambda_.data(), 1, out);
  for (std::size_t i = 0; i < in_impact_.size(); ++i) {
    const auto& s = in_impact_[i];
    if (i < contacts.size())
      d.system.report().contact(contacts[i], q, d.e, d.contacts[contacts[i]].row, s.impulse_n, s.impulse_t, 1,
                                out);
    else
      d.system.report().friction(d.coupled.friction(reacting_[i - contacts.size()]), q,
                                 x.data() + d.system.n(), d.e, d.rows.row(s.tangent), s.impulse_t, 1, out);
    for (const auto& [row, impulse] : {std::pair{s.normal, s.impulse_n}, std::pair{s.tangent, s.impulse_t}})
      for (int k = 0; row >= 0 && k < d.system.n(); ++k)
        out.acceleration[k] += impulse * d.rows.response(row)[k];
  }
}

}  // namespace freeplay
