#include "formulations/time_stepping/contact_record.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace freeplay {
namespace {

/// Duration (s) of the omitted bounces after this contact onset: after a flight of duration D, the
/// following bounces last D (e + e² + …).
double left_out(const StepContact& c) {
  if (!c.soft || !(c.t_left > -INFINITY)) return 0;
  const double flight = c.t_onset - c.t_left;
  return c.restitution < 1 ? flight * c.restitution / (1 - c.restitution) : flight;
}

}  // namespace

/// Logs a separation at the end of the last step with an impulse.
void ContactRecord::log_leave(StepData& s, ContactSet& contacts, int k) {
  auto& c = contacts[k];
  const double t = c.steps > 1 ? c.t_pressed : c.t_onset;
  s.log->leave(k, t, s.system.crank_angle(s.q_old.data()), c.u_n_plus, c.u_t_plus, c.impulse_n, c.impulse_t,
               t - c.t_onset);
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
      s.log->touch(k, c.t_onset, s.system.crank_angle(s.q_old.data()), c.u_n_minus, tangent_minus,
                   std::max(h, left_out(c)), 1.5 * h);
      if (contacts.has_slot(k)) s.log->name(k, contacts.told_as(k), {contacts.pair(k).i, contacts.pair(k).j});
      ++s.totals.work.events;
    }
    c.t_pressed = s.t;
    c.impulse_n += u->impulse_n;
    c.impulse_t += u->impulse_t;
    if (const auto* pushed = s.kernel.pushed(k); pushed && s.whole) {
      c.u_n_plus = pushed->normal - c.bias_n;
      c.u_t_plus = c.row.tangent.size > 0 ? pushed->tangent - c.bias_t : 0;
      continue;
    }
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

}  // namespace freeplay
