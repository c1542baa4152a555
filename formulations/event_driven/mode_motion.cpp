#include "formulations/event_driven/mode_motion.hpp"

#include <algorithm>
#include <utility>

#include "dynamics/system_functions.hpp"

namespace freeplay {

bool ModeMotion::solve(ModeEquations& d, const Vector& x, double t) {
  const auto& system = d.system;
  if (d.coupled.size() > 0) {
    if (!is_finite(x)) return false;  // a stage after a failed one
    d.trouble.clear();
    for (int k = 0; k < d.coupled.size(); ++k) {
      auto& p = d.preloaded[d.coupled.friction(k)];
      d.coupled.near(k) = -p.slip * p.bound;
      p.bound = 0;
    }
  }
  if (!d.solve_free(x, t)) return false;
  hold_rows(d, x);
  auto& rows = d.rows;
  if (rows.used() == 0 && d.coupled.size() == 0) return true;
  solve_rows(d);
  if (passes_pole(d)) return false;
  if (d.coupled.size() > 0 && !add_coupled(d)) return false;
  rows.apply(d.a.data(), d.lambda.data());
  for (int k = 0; k < system.contacts(); ++k) {
    auto& c = d.contacts[k];
    if (c.unknown < 0) continue;
    c.lambda_n = rows.x[c.unknown];
    c.mobility = rows.K(c.unknown, c.unknown);
    if (c.row.tangent.size == 0) continue;
    c.lambda_t = c.slip != 0 ? -c.slip * d.friction_of(k, x.data() + system.n()) * c.lambda_n
                             : rows.x[c.tangent_unknown];
  }
  for (auto& p : d.preloaded)
    if (p.unknown >= 0) p.lambda = rows.x[p.unknown];
  // Bounds from the reactions and the rates.
  for (int i = 0; i < d.coupled.size(); ++i) {
    const int k = d.coupled.friction(i);
    auto& p = d.preloaded[k];
    const auto limit = [&](double side) {
      return system.friction_facts(k).limit(p.slip != 0 ? p.rate : 0, d.lambda.data(), side);
    };
    const double side = p.slip != 0 ? -p.slip : p.lambda;
    p.bound = limit(side);
    p.opposite = d.bound_of(i).directed() ? limit(side < 0 ? 1 : -1) : p.bound;
  }
  return true;
}

bool ModeMotion::solve_compiled(ModeEquations& d, const Vector& x, double t, Compiled& found) {
  const auto& system = d.system;
  if (!system.compiled().functions().motion.motion) return false;
  int closed = -1;
  for (int k = 0; k < system.contacts(); ++k) {
    const auto& c = d.contacts[k];
    if (!c.closed) continue;
    if (closed >= 0 || (c.slip == 0 && system.has_friction(k))) return false;
    closed = k;
  }
  const bool slides = closed >= 0 && d.contacts[closed].slip != 0;
  if (slides && orientation_ < 0) return false;
  // Compiled functions take the coefficient before they have the sliding speed.
  if (slides && system.contact_facts(closed).surface.friction_by_speed()) return false;
  const double *q = x.data(), *v = q + system.n();
  const MotionKernel::At at{t, q, v, q + d.state_offset()};
  d.forget_place();
  d.shared_force = 0;
  if (!kernel_.motion(system, d.saddle, d.e, at, d.a.data(), d.lambda.data(), found.drive)) return false;
  d.placed(q, t);
  for (auto& c : d.contacts) {
    c.unknown = c.tangent_unknown = -1;
    c.lambda_n = c.lambda_t = 0;
  }
  d.rows.clear();
  if (closed >= 0) {
    auto& c = d.contacts[closed];
    const double factor = slides ? -c.slip * *system.contact_facts(closed).surface.friction : 0;
    MotionKernel::Slide slide{};
    if (!kernel_.slide(system, closed, at, factor, c.row, d.a.data(), d.lambda.data(), slide)) return false;
    if (slides) {
      orientation_ = 1;
      if (std::exchange(pole_, false)) d.trouble.clear();
      c.lambda_t = factor * slide.force;
    }
    c.unknown = 0;
    c.lambda_n = slide.force;
    c.mobility = slide.mobility;
    found = {slide.drive, slide.sliding};
  }
  ++d.work.rhs;
  ++d.work.factorisations;
  return true;
}

bool ModeMotion::solve_for_report(ModeEquations& d, const Vector& x, double t) {
  reporting_ = true;
  const bool solved = solve(d, x, t);
  reporting_ = false;
  return solved;
}

/// Sets up the active rows and their right-hand sides.
void ModeMotion::hold_rows(ModeEquations& d, const Vector& x) {
  const auto& system = d.system;
  const double *q = x.data(), *v = q + system.n();
  d.rows.clear();
  const auto want = [&](const SparseRow& row, double gamma, const SparseRow* beside, double factor) {
    const int r = d.add(row, beside, factor);
    d.rows.b[r] = gamma - row.dot(d.a.data());
    return r;
  };
  for (int k = 0; k < system.contacts(); ++k) {
    auto& c = d.contacts[k];
    c.unknown = c.tangent_unknown = -1;
    c.lambda_n = c.lambda_t = 0;
    if (!c.closed) continue;
    system.contact(k, q, v, d.e, c.row);
    const bool rough = c.row.tangent.size > 0;
    const double mu = rough ? d.friction_of(k, v) : 0;
    c.unknown = want(c.row.normal, c.row.gamma_n, c.slip != 0 ? &c.row.tangent : nullptr, -c.slip * mu);
    if (rough && c.slip == 0) c.tangent_unknown = want(c.row.tangent, c.row.gamma_t, nullptr, 0);
  }
  for (auto& p : d.preloaded) {
    p.unknown = -1;
    if (p.slip == 0) p.unknown = want(p.row, p.gamma, nullptr, 0);
  }
}

void ModeMotion::solve_rows(ModeEquations& d) {
  auto& rows = d.rows;
  if (rows.used() == 0) return;
  rows.fill();
  rows.solve();
  if (!rows.dependent()) return;
  d.shared_force = rows.x.cwiseAbs().maxCoeff();
  // Forces are shared in proportion to the bounds. Bounds that depend on reactions are evaluated
  // once, from the forces before.
  for (int i = 0; i < d.coupled.size(); ++i) {
    auto& p = d.preloaded[d.coupled.friction(i)];
    if (p.slip != 0) return;  // its force would not agree with another choice
    const auto& bound = d.bound_of(i);
    p.bound = bound.coefficient(0.0) * bound.support(reactions_with_rows(d, bound), rows.x[p.unknown]);
  }
  share_friction(d);
}

/// The reactions of a joint with the forces of the rows.
ReactionBound::Reactions ModeMotion::reactions_with_rows(const ModeEquations& d, const ReactionBound& bound) {
  auto l = bound.reactions(d.lambda.data());
  for (int r = 0; r < d.rows.used(); ++r) {
    const auto by = bound.reactions(d.rows.reaction(r));
    for (const std::size_t which : {0U, 1U}) l[which] += d.rows.x[r] * by[which];
  }
  return l;
}

/// If sticking rows depend on each other, their forces are not unique. They are shared in
/// proportion to each contact's friction limit (least Σ λ²/bound), so that no contact begins to
/// slip while others could hold. A contact without apparent normal force keeps a small share,
/// because its row may not be satisfied without its force. Where these forces exceed a limit, the
/// nearest ones within all limits are taken, if there are any: sticking ends where none are left.
void ModeMotion::share_friction(ModeEquations& d) {
  Eigen::VectorXd share = Eigen::VectorXd::Ones(d.rows.used());
  for (int k = 0; k < d.system.contacts(); ++k) {
    const auto& c = d.contacts[k];
    if (c.tangent_unknown < 0) continue;
    const double bound = d.system.contact_facts(k).surface.friction_at_rest() * d.rows.x[c.unknown];
    share[c.tangent_unknown] = std::max(bound, 0.0);
  }
  for (const auto& p : d.preloaded)
    if (p.unknown >= 0) share[p.unknown] = p.bound;
  share = (share / share.maxCoeff()).cwiseMax(1e-6);
  d.rows.share(share);
  const Eigen::VectorXd nearest = d.rows.x;
  // Where a contact opens, its forces are zero to rounding, and none may lie within its limits.
  for (const double zero : {0.0, 0.3 * d.force_tolerance(0)})
    for (const bool of_choice : {false, true}) {
      if (of_choice && d.coupled.size() == 0) break;
      admit(d, of_choice, zero);
      if (d.rows.share_within(share, conditions_, constants_)) return;
    }
  d.rows.x = nearest;
}

/// Conditions of the mode on the forces x of the rows, conditions_ x + constants_ ≥ 0; a normal force
/// counts as positive above −`zero` (N). A bound that
/// depends on reactions is at least its tangent at any reactions, because the support force is a
/// norm: at those of the choice of the mode, or at the present ones.
void ModeMotion::admit(ModeEquations& d, bool of_choice, double zero) {
  const auto& rows = d.rows;
  const auto most = 3 * static_cast<Eigen::Index>(d.contacts.size() + d.preloaded.size());
  conditions_.setZero(most, rows.used());
  constants_.setZero(most);
  Eigen::Index n = 0;
  for (int k = 0; k < d.system.contacts(); ++k) {
    const auto& c = d.contacts[k];
    if (c.unknown < 0) continue;
    constants_[n] = zero;
    conditions_(n++, c.unknown) = 1;
    if (c.tangent_unknown < 0) continue;
    const double mu = d.system.contact_facts(k).surface.friction_at_rest();
    for (const int side : {1, -1}) {
      constants_[n] = mu * zero;
      conditions_(n, c.unknown) = mu;
      conditions_(n++, c.tangent_unknown) = side;
    }
  }
  Eigen::RowVectorXd limit;
  for (int k = 0; k < d.system.frictions(); ++k) {
    const auto& p = d.preloaded[k];
    if (p.unknown < 0) continue;
    limit.setZero(rows.used());
    for (const int side : {1, -1}) {  // of a force opposed to it
      double constant = p.bound;
      if (const auto& bound = d.system.friction_facts(k).reaction) {
        const double mu = bound->coefficient(0.0);
        const auto free = bound->reactions(d.lambda.data());
        const auto slope = bound->slope(of_choice ? p.reaction : reactions_with_rows(d, *bound), -side);
        constant = mu * (bound->support({}, -side) + slope[0] * free[0] + slope[1] * free[1]);
        for (int r = 0; r < rows.used(); ++r) {
          const auto by = bound->reactions(rows.reaction(r));
          limit[r] = mu * (slope[0] * by[0] + slope[1] * by[1]);
        }
      }
      conditions_.row(n) = limit;
      conditions_(n, p.unknown) += side;
      constants_[n++] = constant;
    }
  }
  conditions_.conservativeResize(n, Eigen::NoChange);
  constants_.conservativeResize(n);
}

/// Where D_NN − s μ D_NT of a sliding contact (of several rows, the determinant) approaches zero,
/// its forces grow without bound, and beyond zero they are tensile. No step may cross this pole,
/// however well its stages agree (Painlevé).
bool ModeMotion::passes_pole(ModeEquations& d) {
  const auto slides = [](const ModeContact& c) { return c.closed && c.slip != 0 && c.row.tangent.size > 0; };
  if (d.rows.used() == 0 || d.rows.dependent() || std::ranges::none_of(d.contacts, slides)) return false;
  if (orientation_ == 0) orientation_ = d.rows.turn();
  if (d.rows.turn() == orientation_ || reporting_) {
    if (std::exchange(pole_, false)) d.trouble.clear();  // a shorter step ends before the pole
    return false;
  }
  pole_ = true;
  d.trouble =
      "Painlevé paradox: friction admits no finite force at a sliding contact; time stepping finds a "
      "consistent impulse";
  return true;
}

/// Adds the slipping friction that depends on reactions: the effect of a unit of each, including
/// the reaction of the active rows, on d.a, d.lambda and the forces of the rows.
bool ModeMotion::add_coupled(ModeEquations& d) {
  const int n = d.system.n(), m = d.system.rows();
  auto& rows = d.rows;
  auto& coupled = d.coupled;
  const int held = rows.used();
  const auto total = [&](const double* own, const Eigen::VectorXd& forces, int k) {
    double sum = own[k];
    for (int r = 0; r < held; ++r) sum += forces[r] * rows.reaction(r)[k];
    return sum;
  };
  if (held > 0) held_forces_ = rows.x;
  auto& reactions = held_reactions_;
  reactions.resize(static_cast<std::size_t>(m));
  for (int k = 0; k < m; ++k) reactions[k] = total(d.lambda.data(), held_forces_, k);
  coupled.base(reactions.data());
  answers_.resize(static_cast<std::size_t>(coupled.size()));
  int own = held;  // the next place after the active rows
  for (int i = 0; i < coupled.size(); ++i) {
    const int f = coupled.friction(i);
    const auto& p = d.preloaded[f];
    coupled.factor(i) = p.slip * d.bound_of(i).coefficient(p.rate);
    if (p.slip == 0) continue;
    rows.put(own, d.saddle, p.row);
    auto& answer = answers_[i];
    if (held > 0) {
      for (int r = 0; r < held; ++r) rows.b[r] = -rows.row(r).dot(rows.response(own));
      rows.solve();
      answer = rows.x;
    }
    for (int k = 0; k < m; ++k) reactions[k] = total(rows.reaction(own), answer, k);
    coupled.column(i, reactions.data());
    ++own;
  }
  if (held > 0) rows.x = held_forces_;
  if (own == held) return true;
  if (const auto outcome = coupled.follow_branch(); outcome != CoupledFriction::Outcome::solved) {
    d.trouble = words_of(outcome);
    return false;
  }
  d.extremes.friction_residual = std::max(d.extremes.friction_residual, coupled.residual());
  own = held;
  for (int i = 0; i < coupled.size(); ++i) {
    auto& p = d.preloaded[coupled.friction(i)];
    if (p.slip == 0) continue;
    p.lambda = coupled.force(i);
    for (int k = 0; k < n; ++k) d.a[k] += p.lambda * rows.response(own)[k];
    for (int k = 0; k < m; ++k) d.lambda[k] += p.lambda * rows.reaction(own)[k];
    ++own;
    if (held > 0) rows.x += p.lambda * answers_[i];
  }
  return true;
}

}  // namespace freeplay
