#include "formulations/nonsmooth/moreau.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace freeplay {

MoreauStepper::MoreauStepper(const System& system, const NonsmoothOptions& options,
                             std::vector<double> restitution, RowFacts facts)
    : system_(system),
      options_(options),
      saddle_(system.mass(), system.pattern(), SolvePath::automatic, facts),
      e_(system.make_evaluation()),
      end_(system.make_evaluation()),
      problem_(options.solver, options.lcp_tolerance),
      position_problem_(LcpSolver::automatic, options.lcp_tolerance),
      contacts_(system.contacts()),
      slides_(system.frictions()),
      slide_gamma_(system.frictions()),
      slide_last_(system.frictions()) {
  int rows = system.frictions();
  for (int k = 0; k < system.contacts(); ++k) {
    contacts_[k].restitution = restitution[k];
    rows += system.has_friction(k) ? 2 : 1;
    std::vector<double> any(static_cast<std::size_t>(system.n()));  // two bodies alike in none
    std::iota(any.begin(), any.end(), 1.0);
    if (system.passage(k, any.data(), 1) > 0) passing_.push_back(k);
  }
  problem_.reserve(rows);
  position_problem_.reserve(system.contacts());
  rows_.resize(rows);
  response_.resize(static_cast<std::size_t>(rows) * system.n());
  reaction_.resize(static_cast<std::size_t>(rows) * system.rows());
  for (auto* x : {&q_, &v_, &q_old_, &v_old_, &q_mid_, &v_mean_, &v_trial_, &v_free_, &force_, &dq_})
    x->resize(system.n());
  for (auto* x : {&z_, &z_mid_, &flow_}) x->resize(system.states());
  for (auto* x : {&r_, &lambda_, &lambda_free_, &lambda_dq_}) x->resize(system.rows());
  extremes_.penetration.assign(system.contacts(), 0);
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
  }
}

bool MoreauStepper::step(double t_end) {
  t_old_ = t_;
  t_ = t_start_ + static_cast<double>(index_ + 1) * options_.step;
  if (t_ > t_end - 1e-9 * options_.step) {
    t_ = t_end;  // the last step may be shorter
    t_start_ = t_end - static_cast<double>(index_ + 1) * options_.step;
  }
  ++index_;
  const double h = t_ - t_old_;
  std::swap(q_, q_old_);
  std::swap(v_, v_old_);
  const int n = system_.n();
  for (int i = 0; i < n; ++i) q_mid_[i] = q_old_[i] + 0.5 * h * v_old_[i];
  system_.place(t_old_ + 0.5 * h, q_mid_.data(), e_);
  system_.rate(q_mid_.data(), v_old_.data(), e_);
  for (int k = 0; k < system_.contacts(); ++k)
    system_.contact(k, q_mid_.data(), v_old_.data(), e_, contacts_[k].row);
  for (int k = 0; k < system_.frictions(); ++k)
    slide_gamma_[k] = system_.friction(k, q_mid_.data(), v_old_.data(), e_, slides_[k]);
  ++work_.steps;
  ++work_.factorisations;
  if (!saddle_.factor(e_.G.data())) {
    failure_ =
        fmt::format("t = {:.9g} s: the constraint equations are not finite or cannot be factorised", t_old_);
    return false;
  }

  if (!advance_states(h) || !solve_velocities(h, v_old_.data())) return false;
  if (system_.has_velocity_forces()) {
    // Damper forces belong to the mean velocity: iterate to it.
    for (int i = 0;; ++i) {
      double change = 0, size = 0;
      for (int c = 0; c < n; ++c) {
        const double mean = 0.5 * (v_old_[c] + v_[c]);
        change = std::max(change, std::abs(v_[c] - v_trial_[c]));
        size = std::max(size, std::abs(mean));
        v_mean_[c] = mean;
      }
      if (i > 0 && change <= 1e-12 * size) break;
      if (i == 50 || !std::isfinite(change)) {
        failure_ = fmt::format(
            "t = {:.9g} s: the damper forces do not converge within a step of {:.3g} s; take nonsmooth.step "
            "shorter than mass/damping",
            t_old_, h);
        return false;
      }
      v_trial_ = v_;
      if (!solve_velocities(h, v_mean_.data())) return false;
    }
  }
  for (int i = 0; i < n; ++i) q_[i] = q_mid_[i] + 0.5 * h * v_[i];
  log_contacts(h);
  if (watching_) book(h);
  account(h);
  keep_passage(h);
  if (!bring_back(t_)) return false;
  for (double& multiplier : lambda_) multiplier /= h;  // impulses so far
  double sum = 0;
  for (int i = 0; i < n; ++i) sum += q_[i] + v_[i];
  if (!std::isfinite(sum)) {
    failure_ = fmt::format("t = {:.9g} s: the state is no longer finite", t_);
    return false;
  }
  return true;
}

/// z⁺ and its mean z_mid_, which do not depend on v⁺, by fixed-point iteration.
bool MoreauStepper::advance_states(double h) {
  if (z_.empty()) return true;
  z_mid_ = z_;
  for (int i = 0;; ++i) {
    const Sweep sweep{h, v_old_.data()};
    system_.flow(t_old_ + 0.5 * h, q_mid_.data(), z_mid_.data(), flow_.data(), {&sweep});
    double change = 0;
    for (std::size_t k = 0; k < z_.size(); ++k) {
      const double middle = z_[k] + 0.5 * h * flow_[k];
      change = std::max(change, std::abs(middle - z_mid_[k]) / system_.state_scale(static_cast<int>(k)));
      z_mid_[k] = middle;
    }
    if (change <= 1e-13) break;
    if (i == 50 || !std::isfinite(change)) {
      failure_ = fmt::format(
          "t = {:.9g} s: the lagged torques do not converge within a step of {:.3g} s; take nonsmooth.step "
          "shorter than their lag",
          t_old_, h);
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
  const Sweep sweep{h, v_old_.data()};
  system_.forces(t_old_ + 0.5 * h, q_mid_.data(), v_force, z_mid_.data(), e_, {&sweep});
  for (int i = 0; i < n; ++i) force_[i] = system_.mass()[i] * v_old_[i] + h * e_.force[i];
  for (int k = 0; k < m; ++k) r_[k] = -e_.phi_t[k] + 0.5 * h * e_.gamma[k];
  saddle_.solve(force_.data(), r_.data(), v_.data(), lambda_.data());
  if (!saddle_.converged()) {
    failure_ = fmt::format(
        "t = {:.9g} s: constraint rows depend on each other and cannot be met together: a singular position, "
        "as a four-bar's change point (start beside it), or redundant joints on bodies of very unlike mass",
        t_old_);
    return false;
  }

  v_free_ = v_;
  lambda_free_ = lambda_;
  for (auto& c : contacts_) c.active = false;
  // Impulses of the other elements may close a gap that the free motion leaves open: look again with them.
  for (bool first = true; activate(h) || first; first = false) {
    v_ = v_free_;
    lambda_ = lambda_free_;
    collect(h);
    if (problem_.unknowns.empty()) break;
    if (!solve_contacts()) return false;
  }
  return true;
}

void MoreauStepper::account(double h) {
  const int n = system_.n();
  for (int k = 0; k < system_.rows(); ++k) {
    integrals_.drive += lambda_[k] * e_.phi_t[k];
    const double rate = 0.5 * (row_dot(system_.pattern(), e_.G.data(), k, v_old_.data()) +
                               row_dot(system_.pattern(), e_.G.data(), k, v_.data())) +
                        e_.phi_t[k];
    integrals_.stabilisation -= lambda_[k] * rate;
  }
  double gain = 0, approach = 0;  // approach: Σ P_N |u_N⁻|
  for (const auto& c : contacts_)
    if (c.unknown >= 0) approach += problem_.unknowns[c.unknown].impulse_n * std::max(0.0, -c.u_n_minus);
  for (const auto& c : problem_.unknowns) {
    const auto mean_rate = [&](int row) {
      return 0.5 * (rows_[row].dot(v_old_.data()) + rows_[row].dot(v_.data()));
    };
    double work = 0;
    if (c.normal >= 0) {
      const double normal = c.impulse_n * mean_rate(c.normal);
      integrals_.contact -= normal;
      work += normal;
    }
    if (c.tangent >= 0) {
      const double tangential = c.impulse_t * mean_rate(c.tangent);
      integrals_.friction -= tangential;
      work += tangential;
    }
    gain += work;
  }
  // A step's share of lasting contact may add h² times forces; more is an impact that raised the energy.
  if (struck_) extremes_.count_gain(gain > 1e-3 * approach ? gain : 0, system_.kinetic(v_old_.data()), 1e-9);
  if (!system_.has_loads()) return;
  for (int i = 0; i < n; ++i) v_mean_[i] = 0.5 * (v_old_[i] + v_[i]);
  const Sweep sweep{h, v_old_.data()};
  system_.forces(t_old_ + 0.5 * h, q_mid_.data(), v_mean_.data(), z_mid_.data(), e_, {&sweep});
  integrals_.drive += h * e_.power.drive;
  integrals_.load += h * e_.power.load;
  integrals_.damping -= h * e_.power.damping;
}

void MoreauStepper::log_contacts(double h) {
  struck_ = false;
  const auto preloaded = problem_.unknowns.size() - slide_last_.size();
  for (std::size_t k = 0; k < slide_last_.size(); ++k)
    slide_last_[k] = problem_.unknowns[preloaded + k].impulse_t;
  for (int k = 0; k < system_.contacts(); ++k) {
    auto& c = contacts_[k];
    const auto* u = c.unknown >= 0 ? &problem_.unknowns[c.unknown] : nullptr;
    const bool pressed = u && u->impulse_n > 0;
    c.last_n = pressed ? u->impulse_n : 0;
    c.last_t = pressed ? u->impulse_t : 0;
    if (!pressed) {
      if (log_->is_open(k)) {
        const double t = c.steps > 1 ? t_old_ : c.t_touch;
        log_->leave(k, t, system_.crank_angle(q_old_.data()), c.u_n_plus, c.u_t_plus, c.impulse_n,
                    c.impulse_t, t - c.t_touch);
        c.steps = 0;
        c.t_left = t_old_;
      }
      continue;
    }
    const double tangent_minus =
        c.row.tangent.size > 0 ? c.row.tangent.dot(v_old_.data()) + 0.5 * h * c.row.gamma_t : 0;
    if (c.steps++ == 0) {
      struck_ = true;
      // First touch where the gap at the step's beginning closes at its rate there.
      c.t_touch = t_old_ + (c.u_n_minus < 0 ? std::clamp(-c.gap / c.u_n_minus, 0.0, h) : 0);
      c.impulse_n = c.impulse_t = 0;
      if (c.u_n_minus < 0) keep_flight(-c.u_n_minus, (c.t_touch - c.t_left) / options_.step);
      log_->touch(k, c.t_touch, system_.crank_angle(q_old_.data()), c.u_n_minus, tangent_minus, h, 1.5 * h);
      ++work_.events;
    }
    c.impulse_n += u->impulse_n;
    c.impulse_t += u->impulse_t;
    c.u_n_plus = c.row.normal.dot(v_.data()) - 0.5 * h * c.row.gamma_n;
    c.u_t_plus = c.row.tangent.size > 0 ? c.row.tangent.dot(v_.data()) - 0.5 * h * c.row.gamma_t : 0;
  }
}

/// The shortest flight before any of the fastest impacts: which they are, from a quarter to a half of the
/// fastest up, shows as the run goes on.
void MoreauStepper::keep_flight(double approach, double steps) {
  auto& shortest = flights_[std::clamp(std::ilogb(approach) + 96, 1, 127)];
  shortest = std::min(shortest, steps);
  auto fastest = flights_.size() - 1;
  while (!(flights_[fastest] < INFINITY) && fastest > 1) --fastest;
  extremes_.shortest_flight = std::min(flights_[fastest], flights_[fastest - 1]);
}

/// What moves far in a step may come and go between two of them.
void MoreauStepper::keep_passage(double h) {
  for (const int k : passing_)
    for (const auto* v : {&v_old_, &v_})
      if (const double share = system_.passage(k, v->data(), h); share > passage_.share)
        passage_ = {share, k};
}

void MoreauStepper::watch_forces(bool on) {
  watching_ = on;
  if (!on || !smooth_.elements.empty()) return;
  nothing_ = smooth_ = within_ = system_.make_forces();
  struck_lambda_.resize(system_.rows());
  smooth_lambda_.resize(system_.rows());
}

/// The step's impulses: those of contacts that it struck, with what the joints answered, apart from the rest.
void MoreauStepper::book(double h) {
  const int n = system_.n(), m = system_.rows();
  const double* q = q_mid_.data();
  smooth_.clear();
  within_.clear();
  std::ranges::fill(struck_lambda_, 0.0);
  const auto take = [&](int row, double impulse) {
    if (row < 0 || impulse == 0) return;
    for (int k = 0; k < m; ++k) struck_lambda_[k] += impulse * reaction(row)[k];
    for (int i = 0; i < n; ++i) within_.acceleration[i] += impulse * response(row)[i];
  };
  for (int k = 0; k < system_.contacts(); ++k) {
    const auto& c = contacts_[k];
    if (c.unknown < 0) continue;
    const auto& u = problem_.unknowns[c.unknown];
    const bool struck = c.steps == 1 && u.impulse_n > 0;
    if (struck) {
      take(u.normal, u.impulse_n);
      take(u.tangent, u.impulse_t);
    }
    system_.report_contact(k, q, e_, c.row, u.impulse_n, u.impulse_t, 1, struck ? within_ : smooth_);
  }
  for (int k = 0; k < m; ++k) smooth_lambda_[k] = lambda_[k] - struck_lambda_[k];
  system_.report_rows(q, e_, smooth_lambda_.data(), 1, smooth_);
  system_.report_rows(q, e_, struck_lambda_.data(), 1, within_);
  for (int i = 0; i < n; ++i) {
    smooth_.acceleration[i] = v_[i] - v_old_[i] - within_.acceleration[i];
    v_mean_[i] = 0.5 * (v_old_[i] + v_[i]);
  }
  const auto preloaded = problem_.unknowns.size() - slides_.size();
  for (std::size_t k = 0; k < slides_.size(); ++k)
    system_.report_friction(static_cast<int>(k), q, v_mean_.data(), e_, slides_[k],
                            problem_.unknowns[preloaded + k].impulse_t, 1, smooth_);
  const Sweep sweep{h, v_old_.data()};
  system_.report_loads(t_old_ + 0.5 * h, q, v_mean_.data(), z_mid_.data(), e_, h, smooth_, {&sweep});
}

void MoreauStepper::forces(double, Forces& out) {
  out.clear();
  if (t_ > t_old_) out.add(1 / (t_ - t_old_), smooth_);
}

void MoreauStepper::add_impulse(double a, double b, Forces& sum) const {
  if (b > a) sum.add((b - a) / (t_ - t_old_), smooth_);
}

void MoreauStepper::interpolate(double t, double* q, double* v) const {
  const double s = t_ > t_old_ ? (t - t_old_) / (t_ - t_old_) : 1;
  for (int i = 0; i < system_.n(); ++i) {
    q[i] = q_old_[i] + s * (q_[i] - q_old_[i]);
    v[i] = v_old_[i] + s * (v_[i] - v_old_[i]);
  }
}

}  // namespace freeplay
