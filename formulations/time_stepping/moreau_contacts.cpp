// The contact problem of a step of Moreau's: which contacts take part, their rates and laws, and its solution.
#include <fmt/format.h>

#include <algorithm>

#include "formulations/time_stepping/moreau.hpp"

namespace freeplay {

int MoreauStepper::add_row(const SparseRow& row, double end_rate_bias, int place) {
  const int r = problem_.rows++;
  if (many_) many_->place[r] = place;
  rows_[place_of(r)] = row;
  problem_.b[r] = row.dot(v_.data()) + end_rate_bias;
  return r;
}

/// A contact takes part once the motion with the other elements' impulses would have closed its gap by the
/// end of the step. True when one was added.
bool MoreauStepper::activate(double h) {
  bool added = false;
  if (near_) keep_near(h, q_old_.data(), v_old_.data(), v_.data());
  for (const int k : live_) {
    auto& c = contacts_[k];
    if (c.active || c.row.normal.size == 0 || !in_reach(c)) continue;
    const double end_gap = c.row.gap + 0.5 * h * (c.row.normal.dot(v_.data()) - 0.25 * h * c.row.gamma_n);
    added |= c.active = end_gap <= (c.closed ? slack_ : 0);
  }
  return added;
}

/// Which active contacts are struck, open before and approaching faster than rows turn within the step (what is slower has come
/// off a contact that lasts, and goes on with it), and the bias of every one's rates. True where one is.
bool MoreauStepper::find_struck(double h) {
  bool any = false;
  const auto approach = [&](const Contact& c) { return -c.row.normal.dot(v_old_.data()); };
  for (const int k : live_) {
    auto& c = contacts_[k];
    if (!c.active) continue;
    c.bias_n = 0.5 * h * c.row.gamma_n;
    c.bias_t = 0.5 * h * c.row.gamma_t;
    c.struck = reach_ == Reach::all && c.steps == 0 && approach(c) > 10 * std::abs(c.bias_n);
    any |= c.struck;
  }
  if (!any) return false;
  if (system_.rows() == 0)
    std::ranges::fill(a_gamma_, 0.0);
  else
    saddle_.solve(nullptr, e_.gamma.data(), a_gamma_.data(), lambda_dq_.data(), Multipliers::kept);
  any = false;
  for (const int k : live_) {
    auto& c = contacts_[k];
    if (!c.active || !c.struck) continue;
    const double bias = 0.5 * h * c.row.normal.dot(a_gamma_.data());
    c.struck = approach(c) > 10 * std::abs(bias);
    if (!c.struck) continue;
    any = true;
    c.bias_n = bias;
    if (c.row.tangent.size > 0) c.bias_t = 0.5 * h * c.row.tangent.dot(a_gamma_.data());
  }
  return any;
}

/// The contact problem of the active contacts and the preloaded joints.
void MoreauStepper::collect(double h) {
  problem_.clear();
  if (many_) many_->id.clear();
  problem_.least = find_struck(h) ? ContactProblem::Least::where_singular : ContactProblem::Least::never;
  // An impact's impulses are no guess for the step behind it: in a wedge they may be a solution of their own, that jams.
  // In a heap of loose bodies somewhere is always one: there each contact has its own.
  const auto struck_last = [](const Contact& c) { return c.steps == 1 && c.last_n > 0; };
  const bool heap = many_ && system_.rows() == 0,
             any = !heap && std::ranges::any_of(live_, [&](int k) { return struck_last(contacts_[k]); });
  for (const int k : live_) {
    auto& c = contacts_[k];
    c.unknown = -1;
    if (!c.active) continue;
    c.u_n_minus = c.row.normal.dot(v_old_.data()) + c.bias_n;
    ContactUnknown u;
    const int place = many_ ? many_->first[k] : 0;
    u.normal = add_row(c.row.normal, -c.bias_n, place);
    u.target_n = reach_ == Reach::all && !c.soft ? -c.restitution * c.u_n_minus : 0;
    const bool guess = heap ? !struck_last(c) : !any;
    u.impulse_n = guess ? c.last_n : 0;
    if (c.row.tangent.size > 0) {
      const auto& surface = facts_of(k).surface;
      u.tangent = add_row(c.row.tangent, -c.bias_t, place + 1);
      u.friction = *surface.friction;
      u.impulse_t = guess ? c.last_t : 0;
      // Reversal belongs to impacts; a contact that lasts would be driven back by it.
      if (c.u_n_minus < 0 && c.steps == 0 && reach_ == Reach::all && !c.soft)
        u.target_t = -surface.tangential_restitution * (c.row.tangent.dot(v_old_.data()) + c.bias_t);
    }
    c.unknown = static_cast<int>(problem_.unknowns.size());
    problem_.unknowns.push_back(u);
    if (many_) many_->id.push_back(system_.frictions() + k);
  }
  for (int k = 0; k < system_.frictions(); ++k) {
    ContactUnknown u;
    if (many_) many_->id.push_back(k);
    u.tangent = add_row(slides_[k], -0.5 * h * slide_gamma_[k], many_ ? many_->friction[k] : 0);
    u.bound = h * system_.friction_facts(k).bound;
    u.impulse_t = slide_last_[k];
    problem_.unknowns.push_back(u);
  }
}

/// Solves the collected problem and adds its impulses to v and Λ.
bool MoreauStepper::solve_contacts() {
  const int n = system_.n(), m = system_.rows();
  const auto unsolved = [&](const ContactSolution& result) {
    if (failure_.empty())
      failure_ = fmt::format(
          "t = {:.9g} s: the contact problem of {} contacts was not solved by any of {} solvers: residual "
          "{:.2g} m/s",
          t_old_, problem_.unknowns.size(), result.retries, result.residual_rate);
    return false;
  };
  if (many_) {
    const auto result = solve_islands();
    return result.solved || unsolved(result);
  }
  for (int r = 0; r < problem_.rows; ++r) {
    saddle_.respond(rows_[r], nullptr, 0, response(r), reaction(r),
                    late_multipliers_ ? Multipliers::kept : Multipliers::all);
    if (films_.any()) films_.relax(response(r), reaction(r));
  }
  {
    double* D = problem_.D.data();
    const auto size = problem_.D.rows();
    for (int r = 0; r < problem_.rows; ++r) {
      const auto& row = rows_[r];
      for (int s = 0; s <= r; ++s) D[r + s * size] = D[s + r * size] = row.dot(response(s));
    }
  }
  if (films_.any())  // cavitated, they answer one way otherwise than back
    for (int r = 0; r < problem_.rows; ++r)
      for (int s = r + 1; s < problem_.rows; ++s) problem_.D(r, s) = rows_[r].dot(response(s));
  const auto result = coupled_.size() > 0 ? solve_bounds() : solve_laws();
  if (!result.solved) return unsolved(result);
  if (problem_.doubtful()) tell_painleve(result);
  double *v = v_.data(), *lambda = lambda_.data();
  const auto apply = [&](int row, double impulse) {
    if (row < 0 || impulse == 0) return;
    const double *a = response(row), *l = reaction(row);
    for (int i = 0; i < n; ++i) v[i] += impulse * a[i];
    for (int k = 0; k < m; ++k) lambda[k] += impulse * l[k];
  };
  for (const auto& c : problem_.unknowns) {
    if (c.impulse_n == 0 || c.impulse_t == 0) {
      apply(c.normal, c.impulse_n);
      apply(c.tangent, c.impulse_t);
      continue;
    }
    const double *a = response(c.normal), *l = reaction(c.normal), *b = response(c.tangent),
                 *s = reaction(c.tangent);
    for (int i = 0; i < n; ++i) v[i] = v[i] + c.impulse_n * a[i] + c.impulse_t * b[i];
    for (int k = 0; k < m; ++k) lambda[k] = lambda[k] + c.impulse_n * l[k] + c.impulse_t * s[k];
  }
  return true;
}

ContactSolution MoreauStepper::solve_laws() {
  auto result = problem_.solve();
  ++work_.lcp_solves;
  if (!result.solved && strip_restitution()) {  // Newton's law may ask for rates that no impulse gives
    result.count(work_, extremes_);
    result = problem_.solve();
    inelastic_ += result.solved;
  }
  result.count(work_, extremes_);
  return result;
}

/// Takes restitution out of the present problem; false where there was none.
bool MoreauStepper::strip_restitution() {
  bool any = false;
  for (auto& u : problem_.unknowns) {
    any = any || u.target_n != 0 || u.target_t != 0;
    u.target_n = u.target_t = 0;
  }
  return any;
}

}  // namespace freeplay
