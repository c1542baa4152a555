// What the event-driven scheme writes down of a mode, and how it hands over to time stepping and takes over from it.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "formulations/event_driven/event_driven.hpp"

namespace freeplay {

/// The log: impacts, touches that begin to last, and losses of contact.
void EventDriven::record(const std::vector<int>& was_closed) {
  auto& d = dynamics_;
  const double t = method_.t;
  for (int k = 0; k < d.system().contacts(); ++k) {
    const bool was = std::ranges::find(was_closed, k) != was_closed.end(), is = d.contacts()[k].closed;
    const double* impulse = method_.x.data() + d.impulse_offset() + 2 * k;
    const auto& row = d.look(k, method_.x, t);
    const double* now = method_.x.data() + d.system().n();
    const double u = row.normal.dot(now), slide = row.tangent.dot(now);
    const double struck_n = impulse[0] - mark_[k].impulse_n;
    if (!was && (is || struck_n > 0)) {
      // Hops that were cut short are no accumulation whose end is known.
      const double touch = hurried_ ? t : t + ending_[k];
      log_->touch(k, touch, crank(), rate_before_[k], slide_before_[k], std::max(ending_[k], 4e-16 * t), 0);
      mark_[k].t = touch;
    }
    if (!is && (was || struck_n > 0))
      log_->leave(k, t, crank(), u, slide, struck_n, impulse[1] - mark_[k].impulse_t, t - mark_[k].t);
    if (!is) {
      mark_[k].impulse_n = impulse[0];
      mark_[k].impulse_t = impulse[1];
    }
  }
}

void EventDriven::tell(std::vector<std::string>& notes) const {
  const double scale = std::max(most_kinetic_, 1e-300);
  if (ended_.count > 0)
    notes.push_back(fmt::format(
        "{} bounces were ended early, as contacts kicked each other faster than {:.2g} s: their touches are "
        "uncertain by up to {:.2g} s, and up to {:.2g} of the greatest kinetic energy was lost at once",
        ended_.count, span_, ended_.time, ended_.energy / scale));
  if (jams_.count > 0)
    notes.push_back(fmt::format(
        "Painlevé: {} times friction admitted no finite force on what slid, and an impact without collision "
        "ended the sliding: up to {:.2g} of the greatest kinetic energy at once",
        jams_.count, jams_.energy / scale));
  if (unsolved_.count > 0)
    notes.push_back(fmt::format(
        "{} times no solver found forces that friction admits on what slid (whether there are any is not known), and "
        "an impact without collision ended the sliding: up to {:.2g} of the greatest kinetic energy at once",
        unsolved_.count, unsolved_.energy / scale));
  if (inelastic_.count > 0)
    notes.push_back(fmt::format(
        "{} impacts of several contacts were taken without restitution, for no solver found impulses with it: up to "
        "{:.2g} of the greatest kinetic energy was lost at once",
        inelastic_.count, inelastic_.energy / scale));
  if (probe_ && probe_->unreported > 0)
    notes.push_back(fmt::format(
        "DOUBTFUL: at {} instants no solver found the forces of contacts, which are given as none",
        probe_->unreported));
  if (dynamics_.together())
    notes.push_back(fmt::format(
        "modes of contact changed again and again at t = {:.9g} s: from there contacts are decided together, with a tolerance "
        "of 1e-7 at least, and open or slide from {:.2g} m/s on",
        together_since_, dynamics_.rest_speed()));
  if (watching_ && dynamics_.together())
    notes.push_back(
        "DOUBTFUL: forces of contacts that are decided together jump within steps: their impulses over an interval may "
        "miss some per cent");
  if (unloaded_.count > 0)
    notes.push_back(fmt::format(
        "t = {:.6g} s, {}: {} took part in an impact with gaps of {:.1g} m, closed to rounding; a real gap there would "
        "change the motion",
        unloaded_.t, dynamics_.system().contact_facts(unloaded_.contact).name,
        unloaded_.count == 1 ? "an unloaded contact" : fmt::format("{} unloaded contacts", unloaded_.count),
        unloaded_.gap));
  if (dynamics_.wedged > 0)
    notes.push_back(fmt::format(
        "{} impacts of several contacts took Poisson's ratios of impulses: none were found that give each its "
        "share of work by the energetic law",
        dynamics_.wedged));
  if (dynamics_.undecided > 0) notes.push_back(undecided_note(dynamics_.undecided));
  double rounded = 0;
  for (int k = 0; k < dynamics_.system().contacts(); ++k) rounded = std::max(rounded, rounding(k));
  if (merged_ > 1e3 * rounded)
    notes.push_back(fmt::format("contacts up to {:.2g} m apart were struck at once", merged_));
}

void EventDriven::keep_mode() {
  auto& b = before_mode_;
  b.x = method_.x;
  b.contact_loss = dynamics_.contact_loss;
  b.stabilisation = dynamics_.stabilisation;
  b.closed.clear();
  for (const auto& c : dynamics_.contacts()) b.closed.push_back(c.closed || c.resting);
}

void EventDriven::give_back_mode() {
  const auto& b = before_mode_;
  method_.x = b.x;
  dynamics_.contact_loss = b.contact_loss;
  dynamics_.stabilisation = b.stabilisation;
  for (std::size_t k = 0; k < b.closed.size(); ++k) dynamics_.contacts()[k].closed = b.closed[k];
  if (watching_) before_step_.clear();
}

Handover EventDriven::hand_over() const {
  const auto& system = dynamics_.system();
  const auto n = system.n();
  Handover to;
  to.state = {method_.t, {q(), q() + n}, {v(), v() + n}, {z().begin(), z().end()}};
  for (int k = 0; k < system.contacts(); ++k) {
    const auto& c = dynamics_.contacts()[k];
    const auto& mark = mark_[k];
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
  const auto& system = dynamics_.system();
  auto x = method_.x;
  std::ranges::copy(from.state.q, x.begin());
  std::ranges::copy(from.state.v, x.begin() + system.n());
  std::ranges::copy(from.state.z, x.begin() + dynamics_.state_offset());
  double* w = x.data() + dynamics_.integral_offset();
  w[EventDynamics::drive] = from.integrals.drive;
  w[EventDynamics::load] = from.integrals.load;
  w[EventDynamics::damping] = from.integrals.damping;
  w[EventDynamics::friction_loss] = from.integrals.friction;
  if (dynamics_.has_films()) w[EventDynamics::film_loss] = from.integrals.film;
  dynamics_.contact_loss = from.integrals.contact;
  dynamics_.stabilisation = from.integrals.stabilisation;
  dynamics_.extremes = from.extremes;
  dynamics_.work = from.work;
  dynamics_.set_together(false);
  dynamics_.measure_speeds(x);
  for (int k = 0; k < system.contacts(); ++k) {
    auto& c = dynamics_.contacts()[k];
    const auto& was = from.contacts[static_cast<std::size_t>(k)];
    c.closed = was.closed && was.logged;
    c.resting = false;
    // What slides is not to be held.
    const double slide = dynamics_.look(k, x, from.state.t).tangent.dot(from.state.v.data());
    c.slip = std::abs(slide) > dynamics_.rest_speed() ? (slide > 0 ? 1 : -1) : 0;
    c.forced = 0;
    const double* impulse = x.data() + dynamics_.impulse_offset() + 2 * k;
    mark_[k].impulse_n = impulse[0] - was.impulse_n;
    mark_[k].impulse_t = impulse[1] - was.impulse_t;
    mark_[k].t = was.t_touch;
  }
  for (auto& p : dynamics_.preloaded()) p.slip = 1;
  dynamics_.phases.start(system, from.state.q.data(), from.state.v.data());
  dynamics_.forget_place();
  method_ = coarse_;  // the state is known to time stepping's tolerance
  is_coarse_ = true;
  method_.rejected = from.work.rejected;
  method_.start(dynamics_, from.state.t, x);
  last_ = {};
  pending_ = true;
  hurried_ = several_ = false;
  recent_ = block_ = changes_ = slow_windows_ = 0;
  struck_first_ = -1;
  recent_since_ = window_since_ = block_since_ = changes_since_ = last_jam_ = -INFINITY;
  failure_.clear();
}

}  // namespace freeplay
