#include "formulations/time_stepping/moreau.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace freeplay {
namespace {

/// Rows of contacts and friction up to which one dense matrix is the faster way.
constexpr int most_whole_rows = 24;

}  // namespace

MoreauStepper::MoreauStepper(const System& system, const NonsmoothOptions& options, double step,
                             std::vector<double> restitution, RowFacts facts)
    : system_(system),
      step_(step),
      saddle_(system.mass(), system.pattern(), SolvePath::automatic, facts),
      e_(system.make_evaluation()),
      end_(system.make_evaluation()),
      problem_(options.solver, options.lcp_tolerance),
      position_problem_(LcpSolver::automatic, options.lcp_tolerance),
      contacts_(system.contacts()),
      films_(system),
      slides_(system.frictions()),
      coupled_(system),
      redundant_(facts.redundant),
      slide_gamma_(system.frictions()),
      slide_last_(system.frictions()) {
  int rows = system.frictions();
  for (int k = 0; k < system.contacts(); ++k) {
    live_.push_back(k);
    contacts_[k].restitution = restitution[k];
    rows += system.has_friction(k) ? 2 : 1;
    std::vector<double> any(static_cast<std::size_t>(system.n()));  // two bodies alike in none
    std::iota(any.begin(), any.end(), 1.0);
    if (system.passage(k, any.data(), 1) > 0) passing_.push_back(k);
  }
  for (const auto& reader : system.curve_readers()) greatest_.push_back(reader.course.greatest().value);
  if (!system.families().empty()) {
    near_ = std::make_unique<Near>(system);
    near_->restitution.assign(restitution.begin() + system.contacts(), restitution.end());
  }
  if ((near_ || rows > most_whole_rows) && !films_.any() && coupled_.size() == 0) {
    many_ = std::make_unique<Many>(saddle_, system, options, rows);
    problem_.reserve_rates(rows);
    position_problem_.reserve_rates(system.contacts());
  } else {
    problem_.reserve(rows);
    position_problem_.reserve(system.contacts());
    response_.resize(static_cast<std::size_t>(rows) * system.n());
    reaction_.resize(static_cast<std::size_t>(rows) * system.rows());
  }
  late_multipliers_ = !many_ && !films_.any() && coupled_.size() == 0;
  rows_.resize(rows);
  end_impulse_.resize(static_cast<std::size_t>(rows));
  least_impulse_.resize(static_cast<std::size_t>(rows));
  slope_.resize(static_cast<std::size_t>(rows));
  along_.resize(static_cast<std::size_t>(rows));
  held_.resize(static_cast<std::size_t>(rows));
  for (auto* x : {&q_, &v_, &q_old_, &v_old_, &q_mid_, &v_mean_, &v_trial_, &v_free_, &force_, &dq_,
                  &struck_v_, &a_gamma_, &q_end_, &v_end_})
    x->resize(system.n());
  for (auto* x : {&z_, &z_old_, &z_mid_, &flow_}) x->resize(system.states());
  for (auto* x : {&r_, &lambda_, &lambda_free_, &lambda_dq_, &taken_back_}) x->resize(system.rows());
  extremes_.penetration.assign(system.reported(), 0);
}

void MoreauStepper::start(const State& state, ContactLog& log) {
  log_ = &log;
  q_ = q_old_ = state.q;
  v_ = v_old_ = state.v;
  z_.assign(system_.states(), 0);
  std::ranges::copy(state.z, z_.begin());
  t_ = t_old_ = t_start_ = state.t;
  index_ = 0;
  system_.place(t_, q_.data(), end_);
  flights_.fill(INFINITY);
  for (int k = 0; k < system_.contacts(); ++k) {
    contacts_[k].gap = system_.gap(k, q_.data(), end_);
    contacts_[k].t_left = contacts_[k].gap > 0 ? t_ : -INFINITY;
    contacts_[k].closed = false;
  }
  if (near_) {
    auto& list = near_->neighbours;
    list.find(q_.data(), list.advised(2 * step_ * list.fastest(v_.data())));
    seat(q_.data());
    for (const int k : live_)
      if (seated(k)) contacts_[k].t_left = contacts_[k].gap > 0 ? t_ : -INFINITY;
  }
}

bool MoreauStepper::step(double t_end) {
  double t = t_start_ + static_cast<double>(index_ + 1) * step_;
  if (t > t_end - 1e-9 * step_) {
    t = t_end;  // the last step may be shorter
    t_start_ = t_end - static_cast<double>(index_ + 1) * step_;
  }
  ++index_;
  return advance(t, Reach::all);
}

bool MoreauStepper::advance(double t_new, Reach reach) {
  reach_ = reach;
  t_old_ = t_;
  t_ = t_new;
  const double h = t_ - t_old_;
  std::swap(q_, q_old_);
  std::swap(v_, v_old_);
  const int n = system_.n();
  for (int i = 0; i < n; ++i) q_mid_[i] = q_old_[i] + 0.5 * h * v_old_[i];
  system_.place(t_old_ + 0.5 * h, q_mid_.data(), e_);
  if (system_.has_motions()) system_.step_motions(t_old_, t_, e_);
  system_.rate(q_mid_.data(), v_old_.data(), e_);
  for (const int k : live_) look(k, q_mid_.data(), v_old_.data(), e_, contacts_[k].row);
  if (near_) keep_near(h, q_old_.data(), v_old_.data(), v_old_.data());
  for (int k = 0; k < system_.frictions(); ++k)
    slide_gamma_[k] = system_.friction(k, q_mid_.data(), v_old_.data(), e_, slides_[k]);
  ++work_.steps;
  ++work_.factorisations;
  if (many_) many_->begin(saddle_);
  if (!saddle_.factor(e_.G.data())) {
    failure_ =
        fmt::format("t = {:.9g} s: the constraint equations are not finite or cannot be factorised", t_old_);
    return false;
  }
  if (films_.any()) {
    for (int i = 0; i < films_.size(); ++i)
      films_.take(i, contacts_[films_.contact(i)].row, contacts_[films_.contact(i)].gap);
    films_.begin(h, saddle_, v_old_.data());
    films_.linearise(v_old_.data());
  }

  if (coupled_.size() > 0 && saddle_.singular() && !redundant_) {
    failure_ = fmt::format(
        "t = {:.9g} s: constraint rows depend on each other there: the reactions that bound friction in joints are not unique",
        t_old_);
    return false;
  }
  if (system_.has_velocity_flows()) z_old_ = z_;
  if (!advance_states(h, v_old_.data()) || !solve_velocities(h, v_old_.data())) return false;
  const bool sweeps = system_.sweeps();
  if (system_.has_velocity_forces() || sweeps || films_.any()) {
    // Damper forces, and what tables sweep over, belong to the mean velocity: iterate to it. Films by Newton's method.
    for (int i = 0;; ++i) {
      double change = 0, size = 0, place = system_.longest_arm();
      for (int c = 0; c < n; ++c) {
        double mean = 0.5 * (v_old_[c] + v_[c]);
        if (i >= 10 && (sweeps || films_.any()))
          mean = 0.5 * (mean + v_mean_[c]);  // a pulse may throw it to and fro
        // Angular rates by the radius of gyration beside the others.
        const auto& mass = system_.mass();
        const double arm = c % 3 == 2 ? std::sqrt(mass[c] / mass[c - 1]) : 1;
        change = std::max(change, arm * std::abs(v_[c] - v_trial_[c]));
        // At rest rates are the rounding of forces that balance.
        size = std::max(size, arm * std::max(std::abs(mean), 0.01 * h * std::abs(e_.force[c]) / mass[c]));
        place = std::max(place, arm * std::abs(q_mid_[c]));
        v_mean_[c] = mean;
      }
      if (films_.any()) size += films_.greatest_change();
      if (i > 0 && change <= 1e-12 * size) break;
      // Near rest what is left is the rounding of forces that balance, each far greater than their sum: it moves nothing by more
      // than the rounding of its place.
      if (i >= 20 && (change <= 1e-9 * size || h * change <= 1e-16 * place)) break;
      if (films_.any() && i >= 10) {
        if (change <= 1e-9 * size) break;  // contact problems are solved to no more
        if (i == 50 && step_ > 0 && std::isfinite(change)) {
          ++unsettled_;
          break;
        }
      }
      if (i == 100 && sweeps && std::isfinite(change)) {
        ++unswept_;
        break;
      }
      if (i == (sweeps ? 101 : 50) || !std::isfinite(change)) {
        failure_ = fmt::format(
            "t = {:.9g} s: the forces of {} do not converge within a step of {:.3g} s; take a smaller {}{}",
            t_old_, system_.has_velocity_forces() ? "dampers" : "films", h, finer(),
            system_.has_velocity_forces() ? ": a step shorter than mass/damping" : "");
        return false;
      }
      v_trial_ = v_;
      if (system_.has_velocity_flows()) {
        z_ = z_old_;
        if (!advance_states(h, v_mean_.data())) return false;
      }
      if (films_.any()) {
        for (int c = 0; c < n; ++c) v_free_[c] = 2 * v_mean_[c] - v_old_[c];
        films_.linearise(v_free_.data());
      }
      if (!solve_velocities(h, v_mean_.data())) return false;
    }
  }
  if (films_.any()) films_.finish(v_old_.data(), v_.data());
  for (int i = 0; i < n; ++i) q_[i] = q_mid_[i] + 0.5 * h * v_[i];
  log_contacts(h);
  if (struck_) keep_struck();
  if (watching_) book(h);
  account(h);
  if (step_ > 0) keep_passage(h);
  if (step_ > 0) keep_bend();
  if (!bring_back(t_) || (reach_ == Reach::closed && !meet_rates())) return false;
  for (double& multiplier : lambda_) multiplier /= h;  // impulses so far
  double sum = 0;
  for (int i = 0; i < n; ++i) sum += q_[i] + v_[i];
  if (!std::isfinite(sum)) {
    failure_ = fmt::format("t = {:.9g} s: the state is no longer finite", t_);
    return false;
  }
  return true;
}

/// z⁺ and its mean z_mid_ at mean velocities v_mean, by fixed-point iteration.
bool MoreauStepper::advance_states(double h, const double* v_mean) {
  if (z_.empty()) return true;
  z_mid_ = z_;
  for (int i = 0;; ++i) {
    const Sweep sweep{h, v_old_.data(), v_mean};
    system_.flow(t_old_ + 0.5 * h, q_mid_.data(), v_mean, z_mid_.data(), flow_.data(), {&sweep});
    double change = 0;
    for (std::size_t k = 0; k < z_.size(); ++k) {
      const double middle = z_[k] + 0.5 * h * flow_[k];
      change = std::max(change, std::abs(middle - z_mid_[k]) / system_.state_scale(static_cast<int>(k)));
      z_mid_[k] = middle;
    }
    if (change <= 1e-13) break;
    if (i == 50 || !std::isfinite(change)) {
      failure_ = fmt::format(
          "t = {:.9g} s: the lagged torques do not converge within a step of {:.3g} s; take a smaller {}: a step "
          "shorter than their lag, or than a motor's inductance/resistance",
          t_old_, h, finer());
      return false;
    }
  }
  for (std::size_t k = 0; k < z_.size(); ++k) z_[k] += h * flow_[k];
  return true;
}

/// v⁺ from the forces at velocity v_force, with impulses of all active contacts.
bool MoreauStepper::solve_velocities(double h, const double* v_force) {
  const int n = system_.n(), m = system_.rows();
  ++work_.rhs;
  const Sweep sweep{h, v_old_.data(), v_force};
  system_.forces(t_old_ + 0.5 * h, q_mid_.data(), v_force, z_mid_.data(), e_, {&sweep});
  {
    double *f = force_.data(), *r = r_.data();
    const double *mass = system_.mass().data(), *v = v_old_.data(), *force = e_.force.data(),
                 *phi_t = e_.phi_t.data(), *gamma = e_.gamma.data();
    for (int i = 0; i < n; ++i) f[i] = mass[i] * v[i] + h * force[i];
    for (int k = 0; k < m; ++k) r[k] = -phi_t[k] + 0.5 * h * gamma[k];
  }
  saddle_.solve(force_.data(), r_.data(), v_.data(), lambda_.data(),
                late_multipliers_ ? Multipliers::kept : Multipliers::all);
  if (!saddle_.converged()) {
    failure_ = fmt::format(
        "t = {:.9g} s: constraint rows depend on each other and cannot be met together: a singular position, "
        "as a four-bar's change point (start beside it), or redundant joints on bodies of very unlike mass",
        t_old_);
    return false;
  }

  if (films_.any()) films_.resist(v_.data(), lambda_.data());
  v_free_ = v_;
  lambda_free_ = lambda_;
  for (const int k : live_) {
    auto& c = contacts_[k];
    c.struck = false;
    c.active = many_ && c.steps > 1 && c.last_n > 0 && c.row.normal.size > 0 && in_reach(c);  // it lasts
  }
  if (many_) many_->islands.clear();
  // Impulses of the other elements may close a gap that the free motion leaves open: look again with them.
  for (bool first = true; activate(h) || first; first = false) {
    if (!first) {
      v_ = v_free_;
      lambda_ = lambda_free_;
    }
    collect(h);
    if (problem_.unknowns.empty()) break;
    if (!solve_contacts()) return false;
    if (many_ && m == 0)  // a heap: should more join, their problem begins from here
      for (const int k : live_)
        if (auto& c = contacts_[k]; c.active) {
          c.last_n = problem_.unknowns[c.unknown].impulse_n;
          c.last_t = problem_.unknowns[c.unknown].impulse_t;
        }
  }
  if (many_) react_to_all();
  if (late_multipliers_) {
    for (const auto& u : problem_.unknowns) {
      if (u.normal >= 0) rows_[u.normal].add_to(force_.data(), u.impulse_n);
      if (u.tangent >= 0) rows_[u.tangent].add_to(force_.data(), u.impulse_t);
    }
    saddle_.finish(force_.data(), v_.data(), lambda_.data());
  }
  return true;
}

void MoreauStepper::interpolate(double t, double* q, double* v) const {
  const double s = t_ > t_old_ ? (t - t_old_) / (t_ - t_old_) : 1;
  for (int i = 0; i < system_.n(); ++i) {
    q[i] = q_old_[i] + s * (q_[i] - q_old_[i]);
    v[i] = v_old_[i] + s * (v_[i] - v_old_[i]);
  }
}

}  // namespace freeplay
