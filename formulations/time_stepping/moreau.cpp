#include "formulations/time_stepping/moreau.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace freeplay {

MeanVelocity::Verdict MeanVelocity::assess(int iteration, const MidpointTerms& terms, const Motion& motion,
                                           Kind kind, std::vector<double>& v_mean) {
  constexpr int damped_after = 10;  // a pulse of a table may cause oscillations
  constexpr int rounding_after = 20;
  constexpr int most = 50, most_swept = 100;
  const double h = motion.h;
  double change = 0, size = 0, place = motion.reach;
  for (int c = 0; c < terms.n; ++c) {
    double mean = 0.5 * (motion.v_old[c] + motion.v[c]);
    if (iteration >= damped_after && (kind.sweeps || kind.films)) mean = 0.5 * (mean + v_mean[c]);
    // Angular rates are multiplied by the radius of gyration.
    const double arm = c % 3 == 2 ? std::sqrt(terms.mass[c] / terms.mass[c - 1]) : 1;
    change = std::max(change, arm * std::abs(motion.v[c] - last[c]));
    // At rest, rates are the rounding errors of balanced forces.
    size =
        std::max(size, arm * std::max(std::abs(mean), 0.01 * h * std::abs(terms.force[c]) / terms.mass[c]));
    place = std::max(place, arm * std::abs(motion.q_mid[c]));
    v_mean[c] = mean;
  }
  if (kind.films) size += motion.film_change;
  if (iteration > 0 && change <= 1e-12 * size) return Verdict::met;
  // Near rest, the remaining change is the rounding error of balanced forces, each far greater than
  // their sum. It moves no body by more than the rounding error of its position.
  if (iteration >= rounding_after && (change <= 1e-9 * size || h * change <= 1e-16 * place))
    return Verdict::met;
  if (kind.films && iteration >= damped_after) {
    // contact problems are solved to this accuracy only
    if (change <= 1e-9 * size) return Verdict::met;
    if (iteration == most && kind.fixed && std::isfinite(change)) return Verdict::unsettled;
  }
  if (iteration == most_swept && kind.sweeps && std::isfinite(change)) return Verdict::unswept;
  if (iteration == (kind.sweeps ? most_swept + 1 : most) || !std::isfinite(change)) return Verdict::diverged;
  std::copy_n(motion.v, terms.n, last.begin());
  return Verdict::again;
}

namespace {

/// Number of rows of contacts and friction up to which one dense matrix is faster.
constexpr int most_whole_rows = 24;

/// Number of rows of all numbered contacts and friction elements.
int contact_rows(const System& system) {
  int rows = system.frictions();
  for (int k = 0; k < system.contacts(); ++k) rows += system.has_friction(k) ? 2 : 1;
  return rows;
}

/// Whether contact problems are solved in islands. Films and friction with varying bounds need dense
/// responses.
bool many_contacts(const System& system, const FilmStep& films) {
  return (!system.families().empty() || contact_rows(system) > most_whole_rows) && !films.any() &&
         system.reactive_frictions().empty();
}

}  // namespace

MoreauStepper::MoreauStepper(const System& system, const NonsmoothOptions& options, double step,
                             std::vector<double> restitution, RowFacts facts)
    : step_(step),
      redundant_(facts.redundant),
      data_(system, facts),
      contacts_(system, restitution, step),
      films_(system),
      extra_forces_(films_.any() || data_.elastic),
      responses_(system, contact_rows(system), many_contacts(system, films_)),
      problem_(data_, options, contact_rows(system), responses_.many(), films_.any()),
      correction_(data_, options.lcp_tolerance, responses_.many()),
      end_rates_(system, contact_rows(system)),
      record_(system, step),
      resolution_(system),
      flow_(system.states()),
      automatic_solver_(options.solver == LcpSolver::automatic),
      tolerance_(options.lcp_tolerance) {
  mean_.last.resize(system.n());
}

void MoreauStepper::start(const State& state, ContactLog& log) {
  auto& d = data_;
  d.log = &log;
  d.q = d.q_old = state.q;
  d.v = d.v_old = state.v;
  d.z.assign(d.system.states(), 0);
  std::ranges::copy(state.z, d.z.begin());
  d.t = d.t_old = t_start_ = state.t;
  index_ = 0;
  d.system.place(d.t, d.q.data(), d.end);
  record_.start();
  contacts_.start(d, responses_);
}

bool MoreauStepper::step(double t_end) {
  double t = t_start_ + static_cast<double>(index_ + 1) * step_;
  if (t > t_end - 1e-9 * step_) {
    t = t_end;  // the last step may be shorter
    t_start_ = t_end - static_cast<double>(index_ + 1) * step_;
  }
  ++index_;
  return advance(t, StepReach::all);
}

bool MoreauStepper::advance(double t_new, StepReach reach) {
  auto& d = data_;
  d.reach = reach;
  d.t_old = d.t;
  d.t = t_new;
  std::swap(d.q, d.q_old);
  std::swap(d.v, d.v_old);
  return evaluate_middle() && solve_step() && end_step();
}

MidpointTerms MoreauStepper::terms() const {
  const auto& e = data_.middle;
  return {data_.system.n(), data_.system.rows(), data_.system.mass().data(),
          e.force.data(),   e.phi_t.data(),      e.gamma.data()};
}

/// Evaluates everything but forces at q_m, and factorises the saddle point.
bool MoreauStepper::evaluate_middle() {
  auto& d = data_;
  const auto& system = d.system;
  const double h = d.length();
  d.whole = fixed() && !forces_.watching() && !responses_.many() && d.kernel.middle(d, contacts_);
  if (d.whole) {
    ++d.totals.work.steps;
    ++d.totals.work.factorisations;
    ++d.totals.work.rhs;
    problem_.begin(d);
    return true;
  }
  half_step(d.q.size(), h, d.q_old.data(), d.v_old.data(), d.q_mid.data());
  system.place(d.t_old + 0.5 * h, d.q_mid.data(), d.middle);
  if (system.has_motions()) system.step_motions(d.t_old, d.t, d.middle);
  system.rate(d.q_mid.data(), d.v_old.data(), d.middle);
  if (d.elastic) stiffen();
  contacts_.look_at_rows(d, responses_);
  ++d.totals.work.steps;
  ++d.totals.work.factorisations;
  responses_.begin(d.saddle);
  problem_.begin(d);
  if (!d.saddle.factor(d.middle.G.data()))
    return d.fail(fmt::format("t = {:.9g} s: the constraint equations are not finite or cannot be factorised",
                              d.t_old));
  if (films_.any()) {
    for (int i = 0; i < films_.size(); ++i) {
      const auto& c = contacts_[films_.contact(i)];
      films_.take(i, c.row, c.gap);
    }
    films_.begin(h, d.saddle, d.v_old.data());
    films_.linearise(d.v_old.data());
  }
  if (problem_.bounded_by_reactions() && d.saddle.singular() && !redundant_)
    return d.fail(fmt::format(
        "t = {:.9g} s: constraint rows are linearly dependent, so the reactions that bound joint friction "
        "are not unique (redundant joints, or a singular position)",
        d.t_old));
  return true;
}

/// Gives the elastic rows at q_m to the saddle point.
void MoreauStepper::stiffen() {
  auto& d = data_;
  const double h = d.length();
  const auto& rows = d.system.elastic();
  d.system.elastic_rows(d.q_mid.data(), d.middle, d.strain_rows.data(), d.compliance.data());
  for (std::size_t k = 0; k < d.compliance.size(); ++k) {  // those of a tension have no damping
    const double tension = d.compliance[k] - rows.stiffness[k];
    d.compliance[k] =
        1 / (rows.stiffness[k] * h * (0.25 * h + 0.5 * rows.damping[k]) + 0.25 * h * h * tension);
  }
  d.saddle.set_elastic(d.strain_rows, d.compliance);
}

/// Changes the sides of the saddle point to those for v⁺ − v, and removes from the forces at v_force what the
/// elastic rows contain of their damping.
void MoreauStepper::add_elastic(const double* v_force) {
  auto& d = data_;
  const double h = d.length();
  const auto& mass = d.system.mass();
  for (int c = 0; c < d.system.n(); ++c) {
    d.force[c] -= mass[c] * d.v_old[c];
    d.dq[c] = 2 * (v_force[c] - d.v_old[c]);
  }
  for (int k = 0; k < d.system.rows(); ++k)
    d.r[k] -= row_dot(d.system.pattern(), d.middle.G.data(), k, d.v_old.data());
  const auto& rows = d.system.elastic();
  for (int k = 0; k < rows.pattern.rows; ++k) {
    if (rows.damping[k] == 0) continue;
    const double impulse = 0.5 * h * rows.damping[k] * rows.stiffness[k] *
                           row_dot(rows.pattern, d.strain_rows.data(), k, d.dq.data());
    for (int e = rows.pattern.begin[k]; e < rows.pattern.begin[k + 1]; ++e)
      d.force[rows.pattern.column[e]] += impulse * d.strain_rows[e];
  }
}

/// Computes v⁺ and z⁺ with their impulses, and q⁺.
bool MoreauStepper::solve_step() {
  auto& d = data_;
  const bool implicit = d.system.has_velocity_forces() || d.system.curves().sweeps || films_.any();
  if (d.whole)
    return problem_.solve(d, contacts_, responses_, films_) && (!implicit || settle_mean_velocity());
  if (d.system.has_velocity_flows()) d.z_old = d.z;
  if (!advance_states(d.v_old.data()) || !solve_velocities(d.v_old.data())) return false;
  if (implicit) {
    if (!settle_mean_velocity()) return false;
    if (films_.any()) films_.finish(d.v_old.data(), d.v.data());
  }
  advance_positions();
  return true;
}

void MoreauStepper::advance_positions() {
  auto& d = data_;
  half_step(d.q.size(), d.length(), d.q_mid.data(), d.v.data(), d.q.data());
}

/// Damper forces, and the values of swept tables, belong to the mean velocity: fixed-point
/// iteration. Films by Newton's method.
bool MoreauStepper::settle_mean_velocity() {
  auto& d = data_;
  auto& found = d.totals.found;
  const double h = d.length();
  const bool films = films_.any(), dampers = d.system.has_velocity_forces();
  const MeanVelocity::Kind kind{d.system.curves().sweeps, films, fixed()};
  for (int i = 0;; ++i) {
    const MeanVelocity::Motion motion{
        h,          d.q_mid.data(),         d.v_old.data(),
        d.v.data(), d.system.longest_arm(), films ? films_.greatest_change() : 0};
    switch (mean_.assess(i, terms(), motion, kind, d.v_mean)) {
      case MeanVelocity::Verdict::met:
        return true;
      case MeanVelocity::Verdict::unsettled:
        ++found.unsettled;
        return true;
      case MeanVelocity::Verdict::unswept:
        ++found.unswept;
        return true;
      case MeanVelocity::Verdict::diverged:
        return d.fail(fmt::format(
            "t = {:.9g} s: the iteration for the forces of {} does not converge in a step of {:.3g} s; use "
            "a smaller {}{}",
            d.t_old, dampers ? "dampers" : "films", h, finer_key(fixed()),
            dampers ? ", shorter than mass/damping" : ""));
      case MeanVelocity::Verdict::again:
        break;
    }
    if (d.system.has_velocity_flows()) {
      d.z = d.z_old;
      if (!advance_states(d.v_mean.data())) return false;
    }
    if (films) {
      for (int c = 0; c < d.system.n(); ++c) d.dq[c] = 2 * d.v_mean[c] - d.v_old[c];
      films_.linearise(d.dq.data());
    }
    if (!solve_velocities(d.v_mean.data())) return false;
  }
}

/// Computes z⁺ and its mean z_mid at mean velocities v_mean, by fixed-point iteration.
bool MoreauStepper::advance_states(const double* v_mean) {
  auto& d = data_;
  if (d.z.empty()) return true;
  const double h = d.length();
  d.z_mid = d.z;
  for (int i = 0;; ++i) {
    const Sweep sweep{h, d.v_old.data(), v_mean};
    d.system.flow(d.t_old + 0.5 * h, d.q_mid.data(), v_mean, d.z_mid.data(), flow_.data(), {&sweep});
    double change = 0;
    for (std::size_t k = 0; k < d.z.size(); ++k) {
      const double middle = d.z[k] + 0.5 * h * flow_[k];
      change = std::max(change, std::abs(middle - d.z_mid[k]) / d.system.state_scale(static_cast<int>(k)));
      d.z_mid[k] = middle;
    }
    if (change <= 1e-13) break;
    if (i == 50 || !std::isfinite(change))
      return d.fail(fmt::format(
          "t = {:.9g} s: the iteration for lagged torques does not converge in a step of {:.3g} s; use a "
          "smaller {}, shorter than the lag or a motor's inductance/resistance",
          d.t_old, h, finer_key(fixed())));
  }
  for (std::size_t k = 0; k < d.z.size(); ++k) d.z[k] += h * flow_[k];
  return true;
}

/// Computes v⁺ from the forces at velocity v_force, with the impulses of all active contacts.
bool MoreauStepper::solve_velocities(const double* v_force) {
  auto& d = data_;
  const double h = d.length();
  ++d.totals.work.rhs;
  const Sweep sweep{h, d.v_old.data(), v_force};
  d.system.forces(d.t_old + 0.5 * h, d.q_mid.data(), v_force, d.z_mid.data(), d.middle, {&sweep});
  terms().sides(h, d.v_old.data(), d.force.data(), d.r.data());
  if (d.elastic) add_elastic(v_force);
  using Multipliers = SaddlePoint::Multipliers;
  d.saddle.solve(d.force.data(), d.r.data(), d.v.data(), d.lambda.data(),
                 problem_.late_multipliers() ? Multipliers::kept : Multipliers::all);
  if (!d.saddle.converged())
    return d.fail(fmt::format(
        "t = {:.9g} s: dependent constraints cannot be satisfied: a singular position such as a change "
        "point (start beside it), or redundant joints on unequal masses",
        d.t_old));
  if (extra_forces_) {
    for (int c = 0; d.elastic && c < d.system.n(); ++c) d.v[c] += d.v_old[c];
    if (films_.any()) films_.resist(d.v.data(), d.lambda.data());
  }
  return problem_.solve(d, contacts_, responses_, films_);
}

/// Records the step and corrects positions, and the velocities of smooth steps.
bool MoreauStepper::end_step() {
  auto& d = data_;
  record_.record(d, contacts_, problem_, responses_);
  if (d.whole && !d.kernel.end(d, contacts_)) {
    d.whole = false;
    d.saddle.finish(d.force.data(), d.v.data(), d.lambda.data());
    advance_positions();
  }
  if (forces_.watching()) forces_.collect(d, contacts_, problem_, responses_, films_);
  accumulate_energies(d, contacts_, problem_, responses_, films_, record_.in_impact(), fixed());
  if (fixed()) resolution_.assess(d, contacts_);
  correction_.bring_back(d, contacts_, problem_, responses_, films_);
  if (d.smooth() && !end_rates_.meet(d, contacts_, problem_, responses_, forces_)) return false;
  const double h = d.length();
  for (double& multiplier : d.lambda) multiplier /= h;  // lambda was an impulse until here
  double sum = 0;
  for (int i = 0; i < d.system.n(); ++i) sum += d.q[i] + d.v[i];
  if (!std::isfinite(sum))
    return d.fail(
        fmt::format("t = {:.9g} s: the state is no longer finite; use a smaller "
                    "step",
                    d.t));
  return true;
}

void MoreauStepper::interpolate(double t, double* q, double* v) const {
  const auto& d = data_;
  interpolate_step(d.t_old, d.t, t, {d.q_old.data(), d.q.data(), d.v_old.data(), d.v.data()}, d.system.n(), q,
                   v);
}

/// Calls copy() on each member of a Place and the stepper's own data.
template <class Self, class P, class Copy>
void MoreauStepper::each_kept(Self& s, P& p, Copy copy) {
  auto& d = s.data_;
  copy(d.q, p.q);
  copy(d.v, p.v);
  copy(d.z, p.z);
  copy(s.problem_.slide_last, p.slide_last);
  copy(s.contacts_.all(), p.contacts);
  copy(*d.log, p.log);
  copy(d.totals.integrals, p.integrals);
  copy(d.totals.extremes, p.extremes);
  copy(d.totals.found, p.found);
  copy(d.t, p.t);
  copy(d.totals.work.events, p.events);
}

void MoreauStepper::keep(Place& p) const {
  each_kept(*this, p, [](const auto& own, auto& kept) { kept = own; });
  p.slide_scale = problem_.slide_scale();
}

void MoreauStepper::go_back(const Place& p) {
  each_kept(*this, p, [](auto& own, const auto& kept) { own = kept; });
  problem_.set_slide_scale(p.slide_scale);
  data_.failure.clear();
}

void MoreauStepper::extrapolate(const Place& whole) {
  auto& d = data_;
  const auto beyond = [](double& half, double one) { half += (half - one) / 3; };
  for (int i = 0; i < d.system.n(); ++i) {
    beyond(d.q[i], whole.q[i]);
    beyond(d.v[i], whole.v[i]);
  }
  for (std::size_t k = 0; k < d.z.size(); ++k) beyond(d.z[k], whole.z[k]);
  for (const auto term :
       {&EnergyLedger::drive, &EnergyLedger::load, &EnergyLedger::damping, &EnergyLedger::contact,
        &EnergyLedger::friction, &EnergyLedger::film, &EnergyLedger::stabilisation})
    beyond(d.totals.integrals.*term, whole.integrals.*term);
  d.system.place(d.t, d.q.data(), d.end);
  for (int k = 0; k < d.system.contacts(); ++k) contacts_[k].gap = d.system.gap(k, d.q.data(), d.end);
}

}  // namespace freeplay
