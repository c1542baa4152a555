#include "formulations/time_stepping/step_results.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "formulations/time_stepping/step_text.hpp"

namespace freeplay {
namespace {

/// Duration (s) of the omitted bounces after this contact onset: after a flight of duration D, the
/// following bounces last D (e + e² + …).
double left_out(const StepContact& c) {
  if (!c.soft || !(c.t_left > -INFINITY)) return 0;
  const double flight = c.t_onset - c.t_left;
  const double e = c.restitution_at(-c.u_n_minus);
  return e < 1 ? flight * e / (1 - e) : flight;
}

}  // namespace

/// Logs a separation at the end of the last step with an impulse.
void ContactRecord::log_leave(StepData& s, ContactSet& contacts, int k) {
  auto& c = contacts[k];
  const double t = c.steps > 1 ? c.t_pressed : c.t_onset;
  s.log->record_separation(k, t, s.system.crank_angle(s.q_old.data()), c.u_n_plus, c.u_t_plus, c.impulse_n,
                           c.impulse_t, t - c.t_onset);
  c.steps = 0;
  c.t_left = c.t_pressed;
}

void ContactRecord::leave_all_open(StepData& s, ContactSet& contacts) {
  for (int k = 0; k < s.system.contacts(); ++k)
    if (!contacts[k].closed && s.log->is_open(k)) log_leave(s, contacts, k);
}

/// Whether a contact without an impulse in this step has separated. A gap from rounding is closed
/// again within a fixed step. A step shortened by the end of the run is too short for that, so the
/// decision is made over a full step.
bool ContactRecord::leaves(const StepData& s, const StepContact& c) const {
  const double h = s.length();
  if (!(h < step_ * (1 - 1e-9)) || c.row.normal.size == 0) return true;
  const double begin = c.row.normal.dot(s.v_old.data()) + 0.5 * h * c.row.gamma_n,
               end = c.row.normal.dot(s.v.data()) - 0.5 * h * c.row.gamma_n;
  return c.gap + step_ * (begin + 0.5 * step_ * (end - begin) / h) > 0;
}

void ContactRecord::record(StepData& s, ContactSet& contacts, StepProblem& problem,
                           const ImpulseResponses& responses) {
  const double h = s.length();
  in_impact_ = false;
  for (std::size_t k = 0; k < problem.slide_last.size(); ++k)
    problem.slide_last[k] = problem.friction(static_cast<int>(k)).impulse_t;
  for (const int k : contacts.live()) {
    auto& c = contacts[k];
    const auto* u = problem.unknown_of(c);
    const bool pressed = u && u->impulse_n > 0;
    c.last_n = pressed ? u->impulse_n : 0;
    c.last_t = pressed ? u->impulse_t : 0;
    if (!pressed) {
      if (s.log->is_open(k) && !(s.smooth() && c.closed) && leaves(s, c)) log_leave(s, contacts, k);
      continue;
    }
    if (c.steps++ == 0) {
      const double tangent_minus = c.row.tangent.size > 0 ? c.row.tangent.dot(s.v_old.data()) + c.bias_t : 0;
      in_impact_ = true;
      // The onset is where the gap at the step's beginning closes at its rate there.
      const double closing = c.row.normal.dot(s.v_old.data()) + 0.5 * h * c.row.gamma_n;
      c.t_onset = s.t_old + (closing < 0 ? std::clamp(-c.gap / closing, 0.0, h) : 0);
      c.impulse_n = c.impulse_t = 0;
      if (c.u_n_minus < 0 && step_ > 0)
        keep_flight(-c.u_n_minus, (c.t_onset - c.t_left) / step_, s.totals.extremes);
      s.log->record_onset(k, c.t_onset, s.system.crank_angle(s.q_old.data()), c.u_n_minus, tangent_minus,
                          std::max(h, left_out(c)), 1.5 * h);
      if (contacts.has_slot(k))
        s.log->name(k, contacts.reported_index(k), {contacts.pair(k).i, contacts.pair(k).j});
      ++s.totals.work.events;
    }
    c.t_pressed = s.t;
    c.impulse_n += u->impulse_n;
    c.impulse_t += u->impulse_t;
    c.u_n_plus = c.row.normal.dot(s.v.data()) - c.bias_n;
    c.u_t_plus = c.row.tangent.size > 0 ? c.row.tangent.dot(s.v.data()) - c.bias_t : 0;
  }
  if (in_impact_) keep_impacts(s, contacts, problem, responses);
}

/// Sums the responses to the contacts in impact alone.
void ContactRecord::keep_impacts(const StepData& s, const ContactSet& contacts, const StepProblem& problem,
                                 const ImpulseResponses& responses) {
  std::ranges::fill(v_, 0.0);
  double sum = 0, moment = 0;
  for (const int k : contacts.live()) {
    const auto& c = contacts[k];
    const auto* u = problem.unknown_of(c);
    if (!u || c.steps != 1 || !(u->impulse_n > 0)) continue;
    sum += u->impulse_n;
    moment += u->impulse_n * (c.t_onset - s.t_old);
    for (const auto& [row, impulse] :
         {std::pair{u->normal, u->impulse_n}, std::pair{u->tangent, u->impulse_t}})
      if (row >= 0) responses.push(problem.place(row), impulse, v_.data());
  }
  t_ = sum > 0 ? std::clamp(s.t_old + moment / sum, s.t_old, s.t) : s.t;
}

/// Records the shortest flight before any of the fastest impacts. These are the impacts from a
/// quarter to a half of the greatest approach speed upwards, which is only known as the run
/// proceeds.
void ContactRecord::keep_flight(double approach, double steps, Extremes& extremes) {
  auto& shortest = flights_[std::clamp(std::ilogb(approach) + 96, 1, 127)];
  shortest = std::min(shortest, steps);
  auto fastest = flights_.size() - 1;
  while (!(flights_[fastest] < INFINITY) && fastest > 1) --fastest;
  extremes.shortest_flight = std::min(flights_[fastest], flights_[fastest - 1]);
}

void StepForces::watch(const System& system, bool on) {
  watching_ = on;
  if (!on || !smooth_.elements.empty()) return;
  nothing_ = smooth_ = within_ = system.make_forces();
  impact_lambda_.resize(system.rows());
  smooth_lambda_.resize(system.rows());
}

void StepForces::collect(StepData& s, const ContactSet& contacts, const StepProblem& problem,
                         ImpulseResponses& responses, const FilmStep& films) {
  const auto& system = s.system;
  const int n = system.n(), m = system.rows();
  const double h = s.length(), *q = s.q_mid.data();
  const bool many = responses.many();
  bool any_in_impact = false;
  smooth_.clear();
  within_.clear();
  std::ranges::fill(impact_lambda_, 0.0);
  if (many) std::ranges::fill(s.force, 0.0);
  const auto take = [&](int row, double impulse) {
    if (row < 0 || impulse == 0) return;
    const int place = problem.place(row);
    responses.push(place, impulse, within_.acceleration.data());
    if (many) {
      responses.row(place).add_to(s.force.data(), impulse);
      return;
    }
    if (problem.late_multipliers())
      s.saddle.finish(responses.row(row), responses.response(row), responses.reaction(row));
    for (int k = 0; k < m; ++k) impact_lambda_[k] += impulse * responses.reaction(row)[k];
  };
  for (const int k : contacts.live()) {
    const auto& c = contacts[k];
    const auto* u = problem.unknown_of(c);
    if (!u) continue;
    const bool in_impact = c.steps == 1 && u->impulse_n > 0;
    any_in_impact |= in_impact;
    if (in_impact) {
      take(u->normal, u->impulse_n);
      take(u->tangent, u->impulse_t);
    }
    auto& out = in_impact ? within_ : smooth_;
    if (contacts.has_slot(k))
      system.report().contact(contacts.reported_index(k), System::link_of(contacts.shape(k)), q, s.middle,
                              c.row, u->impulse_n, u->impulse_t, 1, out);
    else
      system.report().contact(k, q, s.middle, c.row, u->impulse_n, u->impulse_t, 1, out);
  }
  if (many && any_in_impact) s.saddle.solve(s.force.data(), nullptr, s.dq.data(), impact_lambda_.data());
  if (films.any()) films.report(system, q, s.middle, within_.acceleration.data(), smooth_, within_);
  for (int k = 0; k < m; ++k) smooth_lambda_[k] = s.lambda[k] - impact_lambda_[k];
  system.report().rows(system.pattern(), q, s.middle, smooth_lambda_.data(), 1, smooth_);
  system.report().rows(system.pattern(), q, s.middle, impact_lambda_.data(), 1, within_);
  for (int i = 0; i < n; ++i) {
    smooth_.acceleration[i] = s.v[i] - s.v_old[i] - within_.acceleration[i];
    s.v_mean[i] = 0.5 * (s.v_old[i] + s.v[i]);
  }
  for (std::size_t k = 0; k < problem.slides.size(); ++k)
    system.report().friction(static_cast<int>(k), q, s.v_mean.data(), s.middle, problem.slides[k],
                             problem.friction(static_cast<int>(k)).impulse_t, 1, smooth_);
  const Sweep sweep{h, s.v_old.data(), s.v_mean.data()};
  system.report().loads(s.t_old + 0.5 * h, q, s.v_mean.data(), s.z_mid.data(), s.middle, h, smooth_,
                        {&sweep});
  if (!s.elastic) return;
  for (int i = 0; i < n; ++i) s.dq[i] = 0.25 * h * (s.v[i] - s.v_old[i]);
  system.report().elastic(q, s.middle, s.dq.data(), h, smooth_);
}

namespace {

/// Works of constraint rows: the drives' work, and the work of constraint errors.
void accumulate_row_works(StepData& s) {
  const int first_driven = s.system.rows() - (s.system.has_motions() ? s.system.drive_rows() : 0);
  // If velocities satisfy the rates at both ends (EndRates), the work of all rows on their mean is
  // that of the drives. Ideal joints do no work, and the rotation of their rows within the step is
  // an error of the step that would accumulate from turn to turn.
  const bool met = s.smooth() && s.system.drive_rows() > 0;
  const auto& G = s.system.pattern();
  auto& integrals = s.totals.integrals;
  double drive = integrals.drive, stabilisation = integrals.stabilisation;
  for (int k = 0; k < G.rows; ++k) {
    const double driven = s.middle.phi_t[k];
    const auto work = row_work(G, s.middle.G.data(), k, s.v_mean.data(), s.lambda[k], driven);
    drive += work.driven;
    // A row driven by a curve has its own rates at both ends of the step. It is driven at their
    // mean, not at the mean of the curve.
    if (met || (k >= first_driven && driven != 0))
      drive -= work.rest;
    else
      stabilisation -= work.rest;
  }
  integrals.drive = drive;
  integrals.stabilisation = stabilisation;
}

/// Losses of contacts and friction; returns their total energy gain.
double accumulate_contact_losses(StepData& s, const StepProblem& problem, const ImpulseResponses& responses) {
  auto& integrals = s.totals.integrals;
  double gain = 0;
  for (const auto& c : problem.problem.unknowns) {
    const auto mean_rate = [&](int row) { return responses.row(problem.place(row)).dot(s.v_mean.data()); };
    double work = 0;
    if (c.normal >= 0) {
      const double normal = c.impulse_n * mean_rate(c.normal);
      integrals.contact -= normal;
      work += normal;
    }
    if (c.tangent >= 0) {
      const double tangential = c.impulse_t * mean_rate(c.tangent);
      integrals.friction -= tangential;
      work += tangential;
    }
    gain += work;
  }
  return gain;
}

}  // namespace

void accumulate_energies(StepData& s, const ContactSet& contacts, const StepProblem& problem,
                         const ImpulseResponses& responses, const FilmStep& films, bool in_impact,
                         bool fixed) {
  const double h = s.length();
  auto& integrals = s.totals.integrals;
  if (!s.whole) {
    mean_of(s.v.size(), s.v_old.data(), s.v.data(), s.v_mean.data());
    accumulate_row_works(s);
  }
  if (films.any()) integrals.film += films.loss(s.v_old.data(), s.v.data());
  double approach = 0;  // Σ P_N |u_N⁻|
  for (const int k : contacts.live())
    if (const auto* u = problem.unknown_of(contacts[k]))
      approach += u->impulse_n * std::max(0.0, -contacts[k].u_n_minus);
  const double gain = accumulate_contact_losses(s, problem, responses);
  // Lasting contacts may add a gain of h² times forces per step; a greater gain is from an impact
  // that raised the energy. Adaptive steps over impacts are the shortest steps.
  if (in_impact)
    s.totals.extremes.count_gain(gain > (fixed ? 1e-3 : 1e-5) * approach ? gain : 0,
                                 s.system.kinetic(s.v_old.data()), 1e-9);
  if (!s.system.has_loads()) return;
  const Sweep sweep{h, s.v_old.data(), s.v_mean.data()};
  s.system.forces(s.t_old + 0.5 * h, s.q_mid.data(), s.v_mean.data(), s.z_mid.data(), s.middle, {&sweep});
  integrals.drive += h * s.middle.power.drive;
  integrals.load += h * s.middle.power.load;
  integrals.damping -= h * s.middle.power.damping;
}

}  // namespace freeplay
