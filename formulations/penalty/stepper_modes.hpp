// Changes of mode where a step of the penalty formulation ends at an event, and criteria for steps
// that make no progress.
#pragma once

#include "formulations/penalty/stepper.hpp"

namespace freeplay {

template <class Method>
void PenaltyStepper<Method>::apply_impact(int k) {
  auto& c = f_.contacts()[k];
  const auto& row = f_.contact_row(k, method_.x, method_.t);
  if (!c.in_impact) c.mass = f_.effective_mass(row);
  c.v0 = std::max(touch_speed(c, mark_[k].at), v0_floor_);
  c.in_impact = !c.in_impact;
  restart_ = true;
}

template <class Method>
void PenaltyStepper<Method>::start(const State& state, ContactLog& log) {
  log_ = &log;
  std::ranges::fill(scratch_, 0);
  std::ranges::copy(state.q, scratch_.begin());
  std::ranges::copy(state.v, scratch_.begin() + f_.system().n());
  std::ranges::copy(state.z, scratch_.begin() + f_.state_offset());
  for (auto& c : f_.contacts()) c.closed = false;
  f_.phases.start(f_.system(), state.q.data(), state.v.data());
  method_.start(f_, state.t, scratch_);
  f_.place_end(method_.x, state.t);
  for (int k = 0; k < f_.system().contacts(); ++k) mark_[k].at = sample_end(k);
  find_unloaded();
  for (int k = 0; k < f_.system().contacts(); ++k)
    if (watched(k, mark_[k].at).value < 0 || (mark_[k].at.gap == 0 && mark_[k].at.rate < 0)) close(k);
  // Energy stored in contacts that are compressed at the start is not work of this run.
  method_.x[f_.integral_offset() + PenaltyDynamics::contact_work] =
      f_.elastic_energy(method_.x, state.t).dissipative;
}

template <class Method>
void PenaltyStepper<Method>::resume(const std::vector<PenaltyMode>& modes) {
  for (std::size_t k = 0; k < modes.size(); ++k) {
    auto& c = f_.contacts()[k];
    if (!c.closed || !modes[k].closed) continue;
    const int zone = c.zone;  // follows from the state
    c.mode() = modes[k];
    c.zone = zone;
  }
}

template <class Method>
void PenaltyStepper<Method>::land(Event& event) {
  ++f_.work.events;
  if (event.limit.found())
    limits_.land(f_.system(), f_.state_offset(), method_, f_, event.limit);
  else if (event.contact < 0)
    f_.phases.land(f_.system(), method_, f_, event.crossing);
  else if (event.kind != Event::Kind::gap)
    land_at(method_, f_, event.t);
  else
    land_on_gap(method_, f_, event.t, gap_rounding(f_.system(), event.contact, q()), [&] {
      const auto here = watched(event.contact, sample(event.contact, method_.x, event.t));
      return f_.contacts()[event.contact].closed ? Watched{-here.value, -here.rate} : here;
    });
}

template <class Method>
void PenaltyStepper<Method>::change_mode(const Event& event) {
  if (event.limit.found()) {
    restart_ = true;
    return;
  }
  if (event.contact < 0) {
    f_.phases.cross(f_.system(), event.crossing);
    restart_ = true;
    return;
  }
  auto& c = f_.contacts()[event.contact];
  if (event.kind == Event::Kind::impact) {
    apply_impact(event.contact);
  } else if (event.kind == Event::Kind::slide) {
    const bool up = event.boundary == c.zone_ends().high;
    enter_zone(event.contact, event.boundary + (up ? c.zone_tolerance() : -c.zone_tolerance()));
    restart_ = true;
  } else if (event.kind == Event::Kind::clamp) {
    restart_ = true;
  } else if (c.closed) {
    open(event.contact);
  } else {
    close(event.contact);
  }
}

template <class Method>
void PenaltyStepper<Method>::enter_zone(int k, double slide) {
  auto& c = f_.contacts()[k];
  if (!c.shear) {
    c.zone = c.friction->zone(slide);
    return;
  }
  // Between stick and slip the force is continuous.
  if (c.zone != 0) {
    const auto& s = mark_[k].at;
    method_.x[f_.bristle_offset() + k] = c.zone * c.shear->mu * c.normal_force(s.gap, s.rate);
  }
  c.zone = c.zone != 0 ? 0 : slide > 0 ? 1 : -1;
  mark_[k].at = sample_end(k);
}

template <class Method>
void PenaltyStepper<Method>::follow_zone(int k) {
  const auto& c = f_.contacts()[k];
  if (c.shear && c.zone != 0) return;
  const auto [low, high] = c.zone_ends();
  const double slide = mark_[k].at.slide;
  if (slide >= low - c.zone_tolerance() && slide <= high + c.zone_tolerance()) return;
  enter_zone(k, slide);
  restart_ |= c.shear.has_value();  // its rate jumps, which that of a coefficient does not
}

template <class Method>
void PenaltyStepper<Method>::inform_method(const Event& event) {
  const bool soon = event.kind == Event::Kind::slide && f_.work.steps - last_slide_ <= 4;
  chatter_ = soon ? chatter_ + 1 : 0;
  if (event.kind == Event::Kind::slide) last_slide_ = f_.work.steps;
  if (chatter_ >= 30)
    method_.relieve();
  else
    method_.new_mode();
}

template <class Method>
void PenaltyStepper<Method>::change_coincident(const Event& first) {
  for (int k = 0; k < f_.system().contacts(); ++k) {
    if (k == first.contact) continue;
    const auto at = watched(k, mark_[k].at);
    if (at.value > 4 * gap_rounding(f_.system(), k, q()) || !(at.rate < 0)) continue;
    ++f_.work.events;
    if (f_.contacts()[k].closed)
      open(k);
    else
      close(k);
  }
}

template <class Method>
void PenaltyStepper<Method>::close(int k) {
  auto& c = f_.contacts()[k];
  const auto& row = f_.contact_row(k, method_.x, method_.t);
  const double rate = row.normal.dot(v()), slide = row.tangent.dot(v());
  c.closed = true;
  c.v0 = std::max(-rate, v0_floor_);
  c.mass = f_.effective_mass(row);
  c.in_impact = false;
  // closed without an impact
  c.eased = -rate < v0_floor_ || unloaded_[static_cast<std::size_t>(k)];
  const int p = f_.impulse_offset() + 2 * k;
  mark_[k] = {{row.gap, rate, slide}, method_.x[p], method_.x[p + 1], method_.t};
  if (c.friction) c.zone = c.friction->zone(slide);
  if (f_.bristles()) method_.x[f_.bristle_offset() + k] = 0;
  if (c.shear) {
    // A contact that is compressed already has an undeformed spring.
    const bool onset = -row.gap <= 64 * gap_rounding(f_.system(), k, q());
    c.zone = onset ? c.shear->first_zone(-rate, c.force(0.0, -rate, 1.0), slide) : 0;
    mark_[k].at = sampled(k, row, method_.x);
  }
  const double duration = elastic_duration(c.law.elastic, c.mass, c.v0);
  log_->touch(k, method_.t, crank(), rate, slide, time_uncertainty(), 4 * duration);
  restart_ = true;
  method_.limit_step(0.05 * duration);
}

template <class Method>
void PenaltyStepper<Method>::open(int k) {
  const auto& row = f_.contact_row(k, method_.x, method_.t);
  const double rate = row.normal.dot(v()), slide = row.tangent.dot(v());
  f_.contacts()[k].closed = false;
  const int p = f_.impulse_offset() + 2 * k;
  if constexpr (Method::fixed_step)
    keep_short_contact(method_.t - mark_[k].t,
                       std::abs(method_.x[p] - mark_[k].impulse_n) / f_.contacts()[k].mass);
  log_->leave(k, method_.t, crank(), rate, slide, method_.x[p] - mark_[k].impulse_n,
              method_.x[p + 1] - mark_[k].impulse_t, method_.t - mark_[k].t);
  mark_[k].at = {row.gap, rate, slide};
  restart_ = true;
}

template <class Method>
std::string PenaltyStepper<Method>::failure() const {
  if (lost_)
    return fmt::format(
        "t = {:.9g} s: the state is no longer finite; use a smaller penalty.tolerance or penalty.step",
        t_old());
  if (f_.trouble()) return fmt::format("t = {:.9g} s: {}", t_old(), f_.trouble());
  if (creeps_)
    return fmt::format(
        "t = {:.9g} s: steps of {:.2g} s, the motion is too stiff for this integrator; use "
        "penalty.integrator = \"rosenbrock4\" or, for contacts from rest, a greater penalty.v0_floor",
        t(), t() - t_old());
  if (stalled_ >= most_stalled())
    return fmt::format(
        "t = {:.9g} s: {} repeatedly without progress in time; use a smaller penalty.step or "
        "penalty.tolerance",
        t(),
        f_.system().contacts() > 0 ? "a contact opens and closes"
                                   : "an angle or a length crosses a kink of its table");
  return fmt::format(
      "t = {:.9g} s: every step is rejected, however small: the motion may be singular there (such as at "
      "a change point), or penalty.tolerance is below rounding error",
      t_old());
}

template <class Method>
bool PenaltyStepper<Method>::progresses(bool event, double run_end) {
  stalled_ = method_.t > method_.t_old ? 0 : stalled_ + 1;
  if (event && ++paced_ == 5000) {  // many events in a negligible time are no motion
    if (method_.t - paced_since_ < 1e-9 * ahead(run_end)) stalled_ = most_stalled();
    paced_ = 0;
    paced_since_ = method_.t;
  }
  return stalled_ < most_stalled();
}

template <class Method>
bool PenaltyStepper<Method>::creep(double run_end) {
  const bool lasts = Method::may_creep && events_since_ == f_.work.events &&
                     std::ranges::any_of(f_.contacts(), &PenaltyContact::closed);
  const double gained = method_.t - creep_since_;
  creep_since_ = method_.t;
  events_since_ = f_.work.events;
  return gained < (lasts ? 1e-3 : 1e-7) * ahead(run_end);
}

template <class Method>
void PenaltyStepper<Method>::keep_short_contact(double duration, double change) {
  if (!std::isfinite(change)) return;
  const double angle = std::numbers::pi * method_.length() / duration;
  const double lost = std::min(1.0, angle * angle * angle * angle / 120) * change;
  short_.greatest = std::max(short_.greatest, change);
  if (lost > short_.lost) short_.lost = lost, short_.duration = duration;
}

template <class Method>
void PenaltyStepper<Method>::keep_pulse() {
  const auto& system = f_.system();
  const auto n = static_cast<std::size_t>(system.n());
  pulses_.resize(static_cast<std::size_t>(system.phases()));
  for (int k = 0; k < system.phases(); ++k) {
    if (system.phase(k).speed) continue;
    const auto rate = [&](const Vector& x, const double* v) { return system.phase(k).at(x.data(), v).rate; };
    const double a0 = rate(method_.x_old, method_.dxdt_old.data() + n),
                 a1 = rate(method_.x, method_.dxdt.data() + n);
    const double w0 = rate(method_.x_old, method_.x_old.data() + n),
                 w1 = rate(method_.x, method_.x.data() + n);
    auto& pulse = pulses_[static_cast<std::size_t>(k)];
    pulse.change = std::max(pulse.change, std::abs(a1 - a0) * (method_.t - method_.t_old));
    pulse.speed = std::max({pulse.speed, std::abs(w0), std::abs(w1)});
  }
}

}  // namespace freeplay
