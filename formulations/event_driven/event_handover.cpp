// EventDriven: contact log, notes and energies; the state before a change of mode; handover to and
// from time stepping.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "formulations/event_driven/event_driven.hpp"
#include "values/diagnostic.hpp"

namespace freeplay {

/// Logs impacts, onsets of lasting contacts, and separations.
void EventDriven::record(const std::vector<int>& was_closed) {
  auto& d = dynamics_;
  const double t = method_.t, crank = d.system.crank_angle(q());
  for (int k = 0; k < d.system.contacts(); ++k) {
    const bool was = std::ranges::find(was_closed, k) != was_closed.end(), is = d.contacts[k].closed;
    const double* impulse = method_.x.data() + d.impulse_offset() + 2 * k;
    const auto& row = d.look(k, method_.x, t);
    const double* now = method_.x.data() + d.system.n();
    const double u = row.normal.dot(now), slide = row.tangent.dot(now);
    auto& at = onsets_[k];
    const double impulse_of_impact = impulse[0] - at.impulse_n;
    if (!was && (is || impulse_of_impact > 0)) {
      const double ending = impacts_.ending(k);
      at.t = t + ending;
      log_->record_onset(k, at.t, crank, impacts_.rate(k), impacts_.sliding(k), std::max(ending, 4e-16 * t),
                         0);
    }
    if (!is && (was || impulse_of_impact > 0))
      log_->record_separation(k, t, crank, u, slide, impulse_of_impact, impulse[1] - at.impulse_t, t - at.t);
    if (!is) {
      at.impulse_n = impulse[0];
      at.impulse_t = impulse[1];
    }
  }
}

void EventDriven::add_notes(std::vector<std::string>& notes) const {
  double rounding = 0;
  for (int k = 0; k < dynamics_.system.contacts(); ++k)
    rounding = std::max(rounding, gap_rounding(dynamics_.system, k, q()));
  findings_.add_notes(dynamics_.system, rounding, notes);
  if (const long count = forces_.unreported(); count > 0)
    notes.push_back(diagnostic<Diagnostic::forces_unknown>(count));
  if (method_.reliefs() > 0 && dynamics_.system.elastic().pattern.rows > 0)
    notes.push_back(diagnostic<Diagnostic::implicit_steps>(method_.reliefs()));
  if (dynamics_.counts.wedged > 0)
    notes.push_back(diagnostic<Diagnostic::poisson_instead>(dynamics_.counts.wedged));
  if (dynamics_.counts.unresolved > 0)
    notes.push_back(diagnostic<Diagnostic::limit_unresolved>(dynamics_.counts.unresolved));
  if (const long count = dynamics_.counts.undecided; count > 0)
    notes.push_back(diagnostic<Diagnostic::not_searched>(count, most_for_modes));
}

bool EventDriven::in_contact() const {
  return !dynamics_.system.reactive_frictions().empty() ||
         std::ranges::any_of(dynamics_.contacts, [](const auto& c) { return c.closed; });
}

std::array<double, 2> EventDriven::outside_work() const {
  const double* w = method_.x.data() + dynamics_.integral_offset();
  return {w[EventDynamics::drive], w[EventDynamics::load]};
}

EnergyLedger EventDriven::integrals() const {
  const double* w = method_.x.data() + dynamics_.integral_offset();
  EnergyLedger l;
  l.drive = w[EventDynamics::drive];
  l.load = w[EventDynamics::load];
  l.damping = w[EventDynamics::damping];
  l.friction = w[EventDynamics::friction_loss];
  if (dynamics_.films.any()) l.film = w[EventDynamics::film_loss];
  l.contact = dynamics_.contact_loss;
  l.stabilisation = dynamics_.stabilisation;
  return l;
}

void EventDriven::keep_mode() {
  auto& b = mode_before_;
  b.x = method_.x;
  b.contact_loss = dynamics_.contact_loss;
  b.stabilisation = dynamics_.stabilisation;
  b.closed.clear();
  for (const auto& c : dynamics_.contacts) b.closed.push_back(c.closed || c.resting);
}

void EventDriven::give_back_mode() {
  const auto& b = mode_before_;
  method_.x = b.x;
  dynamics_.contact_loss = b.contact_loss;
  dynamics_.stabilisation = b.stabilisation;
  for (std::size_t k = 0; k < b.closed.size(); ++k) dynamics_.contacts[k].closed = b.closed[k];
  forces_.clear_before();
}

Handover EventDriven::hand_over() const {
  const auto& system = dynamics_.system;
  const auto n = system.n();
  Handover to;
  to.state = {method_.t, {q(), q() + n}, {v(), v() + n}, {z().begin(), z().end()}};
  for (int k = 0; k < system.contacts(); ++k) {
    const auto& c = dynamics_.contacts[k];
    const auto& mark = onsets_[k];
    const double* impulse = method_.x.data() + dynamics_.impulse_offset() + 2 * k;
    to.contacts.push_back({c.closed || c.resting, log_->is_open(k), mark.t, impulse[0] - mark.impulse_n,
                           impulse[1] - mark.impulse_t});
  }
  to.integrals = integrals();
  to.extremes = dynamics_.extremes;
  to.work = dynamics_.work;
  return to;
}

void EventDriven::take_over(const Handover& from) {
  const auto& system = dynamics_.system;
  auto x = method_.x;
  std::ranges::copy(from.state.q, x.begin());
  std::ranges::copy(from.state.v, x.begin() + system.n());
  std::ranges::copy(from.state.z, x.begin() + dynamics_.state_offset());
  double* w = x.data() + dynamics_.integral_offset();
  w[EventDynamics::drive] = from.integrals.drive;
  w[EventDynamics::load] = from.integrals.load;
  w[EventDynamics::damping] = from.integrals.damping;
  w[EventDynamics::friction_loss] = from.integrals.friction;
  if (dynamics_.films.any()) w[EventDynamics::film_loss] = from.integrals.film;
  dynamics_.contact_loss = from.integrals.contact;
  dynamics_.stabilisation = from.integrals.stabilisation;
  dynamics_.extremes = from.extremes;
  dynamics_.work = from.work;
  dynamics_.measure_speeds(x);
  for (int k = 0; k < system.contacts(); ++k) {
    auto& c = dynamics_.contacts[k];
    const auto& was = from.contacts[static_cast<std::size_t>(k)];
    c.closed = was.closed && was.logged;
    c.resting = false;
    // Sliding contacts must not be held by the projection.
    const double slide = dynamics_.look(k, x, from.state.t).tangent.dot(from.state.v.data());
    c.slip = std::abs(slide) > dynamics_.slide_tolerance() ? (slide > 0 ? 1 : -1) : 0;
    const double* impulse = x.data() + dynamics_.impulse_offset() + 2 * k;
    onsets_[k].impulse_n = impulse[0] - was.impulse_n;
    onsets_[k].impulse_t = impulse[1] - was.impulse_t;
    onsets_[k].t = was.t_onset;
  }
  for (auto& p : dynamics_.preloaded) p.slip = 1;
  dynamics_.phases.start(system, from.state.q.data(), from.state.v.data());
  dynamics_.forget_place();
  method_ = coarse_;  // the state has the accuracy of time stepping's tolerance
  is_coarse_ = true;
  method_.rejected = from.work.rejected;
  method_.start(dynamics_, from.state.t, x);
  last_ = {};
  pending_ = true;
  pace_.restart();
  last_lockup_ = -INFINITY;
  failure_.clear();
}

}  // namespace freeplay
