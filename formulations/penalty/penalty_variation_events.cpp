// PenaltyVariation: derivatives across events.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "formulations/integrators/kinks.hpp"
#include "formulations/penalty/penalty_variation.hpp"

namespace freeplay {
namespace {

/// Least gap rate at an event whose time has a derivative, over the scene's speed: rounding of velocities.
constexpr double least_crossing_rate = 1e-12;
/// Distance of a demand from its limit, in roundings, at which the step has ended there.
constexpr double at_limit = 100;
/// Relative difference of speeds that the location of an event explains: a rate at its turn, w at v₀.
constexpr double located_speed = 1e-6;

/// The phases whose pieces differ.
std::vector<int> other_pieces(const System& system, const Phases& a, const Phases& b) {
  std::vector<int> list;
  for (int k = 0; k < system.phases(); ++k)
    if (a.pieces()[k].low != b.pieces()[k].low || a.pieces()[k].high != b.pieces()[k].high) list.push_back(k);
  return list;
}

}  // namespace

PenaltyVariation::EventMap PenaltyVariation::event_at(const Vector& x, double t, Side before, Side after) {
  return {x, t, std::move(before), std::move(after), curved_speed(*probe_, x), Vector(keys_.size())};
}

void PenaltyVariation::set_times(EventMap& e, const Function& value) {
  const auto centre = value(*probe_, e.x, e.t);
  const double rate = along(*probe_, value, centre, e.x, e.t, e.before.f, 1, e.speed).slope[0];
  VariedColumns::set_times(e, value, rate, nullptr, false);
}

void PenaltyVariation::cross_events() {
  const auto& d = run_.dynamics();
  const double t = run_.t();
  cross_limits();
  struct Changed {
    int contact;
    bool gap;
  };
  std::vector<Changed> changes;
  for (int k = 0; k < d.system().contacts(); ++k) {
    const auto &was = probe_->contacts()[k], &now = d.contacts()[k];
    if (was.closed != now.closed)
      changes.push_back({k, true});
    else if (was.closed && was.in_impact != now.in_impact)
      changes.push_back({k, false});
  }
  const auto crossed = other_pieces(d.system(), probe_->phases(), d.phases);
  if (changes.empty() && crossed.empty()) return;
  auto x = run_.x();
  x.insert(x.end(), retained_.begin(), retained_.end());
  after_->take_mode(d);
  probe_->touch(true);
  after_->touch(true);
  auto e = event_at(x, t, side(*probe_, x, t), side(*after_, with_retained(d), t));
  const int n = d.system().n();
  const bool jumped = jumps(e.before, e.after);
  if (jumped && changes.size() + crossed.size() > 1)
    refuse(fmt::format(
        "t = {:.9g} s: several forces change at the same time, and one of them jumps; the motion there "
        "depends on their order",
        t));
  if (jumped && changes.empty()) {
    const int k = crossed[0];
    const auto &was = probe_->phases().pieces()[k], &now = d.phases.pieces()[k];
    const double kink = now.low == was.high ? was.high : was.low;
    const Function value = [&](ExtendedPenalty& f, const Vector& y, double) {
      return Vector{from_kink(probe_->system, f.system, k, kink, y)};
    };
    set_times(e, value);
    jump(e);
  }
  for (const auto& [k, gap] : changes) {
    std::ranges::fill(e.dt, 0.0);
    if (!gap) {
      change_impact(k, e, jumped);
      continue;
    }
    const bool onset = d.contacts()[k].closed;
    const auto& row = probe_->row(k, x, t);
    const auto normal = row.normal;
    const Function value = [k = k](ExtendedPenalty& f, const Vector& y, double at) {
      return Vector{f.row(k, y, at).gap};
    };
    const double rate = normal.dot(x.data() + n), away = probe_->gap_acceleration(k, x, e.before.f, t);
    const auto& facts = d.system().contact_facts(k);
    if (onset) refuse_grazing(k, e, rate, away);
    const bool steady = std::abs(rate) > least_crossing_rate * probe_->speed_scale();
    if (!steady && jumped)
      refuse(
          fmt::format("t = {:.9g} s: contact {} opens or closes without relative speed, and its force jumps",
                      t, facts.name));
    if (steady) VariedColumns::set_times(e, value, rate, &normal, false);
    if (onset)
      begin_contact(k, e);
    else
      end_contact(k, e);
    if (onset && !steady) {
      auto& last = onsets_.back();
      last.dt = last.drate = Vector(keys_.size(), NAN);
      for (auto& reason : last.reasons)
        if (reason.empty())
          reason = fmt::format("t = {:.9g} s: contact {} closes without approach", t, facts.name);
    }
    if (jumped) jump(e);
    if (d.bristles() == 0) continue;
    const auto bristle = static_cast<std::size_t>(d.bristle_offset()) + static_cast<std::size_t>(k);
    if (onset && !steady && e.after.f[bristle] != 0)
      refuse(fmt::format(
          "t = {:.9g} s: contact {} closes without approach, so that its bristle has no derivative", t,
          facts.name));
    for (std::size_t c = 0; c < keys_.size(); ++c)
      if (open(c)) S_[c][bristle] = onset ? -e.after.f[bristle] * e.dt[c] : 0;
  }
  probe_->touch(false);
  after_->touch(false);
}

/// Limits of controllers at which a step ends. The rates of their states may jump there.
void PenaltyVariation::cross_limits() {
  const double t = run_.t();
  auto x = run_.x();
  x.insert(x.end(), retained_.begin(), retained_.end());
  for (int k = 0; k < probe_->system.limiters(); ++k) {
    const double w = demand(*probe_, k, x, t), border = w > 0 ? 1 : -1;
    if (!(std::abs(w - border) <= at_limit * Limits::rounding)) continue;
    const auto here = side(*probe_, x, t);
    auto e = event_at(x, t, here, here);
    take_sides_of_limit(e, *probe_, k, x);
    if (!jumps(e.before, e.after)) continue;
    const Function value = [&](ExtendedPenalty& f, const Vector& y, double at) {
      return Vector{demand(f, k, y, at) - border};
    };
    set_times(e, value);
    jump(e);
  }
}

/// S across an event where f jumps.
void PenaltyVariation::jump(const EventMap& e) {
  const auto &before = e.before, &after = e.after;
  for (std::size_t c = 0; c < keys_.size(); ++c) {
    if (!open(c)) continue;
    const double dt = e.dt[c];
    // Velocities are continuous; accelerations jump.
    if (peaks_.any()) peaks_.jump(c, {before.f, before.f, before.f, before.f, before.f, after.f, dt});
    for (std::size_t i = 0; i < size_; ++i) S_[c][i] += dt * (before.f[i] - after.f[i]);
    for (std::size_t i = 0; i < integrands_.size(); ++i)
      integral_rates_[c][i] += dt * (before.integrands[i] - after.integrands[i]);
  }
}

/// Derivatives of v₀, which is `speed` or else the floor, and of a new mass. The function has the speed, or
/// its square.
void PenaltyVariation::retain(int k, const EventMap& e, double speed, const Function& speed_of, bool squared,
                              bool new_mass) {
  const auto& d = run_.dynamics();
  const auto slot = static_cast<std::size_t>(d.size()) + 2 * static_cast<std::size_t>(k);
  const bool floored = !(speed > v0_floor_);
  if (!d.contacts()[k].law.hysteretic()) return;  // the force does not depend on them
  if (floored && !floor_given_)
    refuse(fmt::format(
        "t = {:.9g} s: contact {} begins below the least v₀, which depends on the scene's speeds; "
        "set penalty.v0_floor for derivatives",
        e.t, d.system().contact_facts(k).name));
  const Function mass_of = [k](ExtendedPenalty& g, const Vector& y, double at) {
    return Vector{g.effective_mass(k, y, at)};
  };
  const double scale = std::max(std::abs(speed), v0_floor_);
  for (std::size_t c = 0; c < keys_.size(); ++c) {
    if (!open(c)) continue;
    const auto dx = carried(e, c);
    // w² is smooth. Where it hardly changes along a column, the rounding of the gap would pass for a kink.
    double change = floored ? 0 : total(c, speed_of, e.x, e.t, dx, e.dt[c], scale, !squared)[0];
    if (squared) change /= 2 * speed;
    double mass = S_[c][slot + 1];
    if (new_mass) mass = total(c, mass_of, e.x, e.t, dx, e.dt[c], scale)[0];
    if (!open(c)) continue;
    S_[c][slot] = change;
    S_[c][slot + 1] = mass;
  }
}

void PenaltyVariation::begin_contact(int k, const EventMap& e) {
  const auto& d = run_.dynamics();
  const auto slot = static_cast<std::size_t>(d.impulse_offset()) + 2 * static_cast<std::size_t>(k);
  const double rate = probe_->gap_rate(k, e.x, e.t);
  const Function rate_of = [k](ExtendedPenalty& f, const Vector& y, double at) {
    return Vector{f.gap_rate(k, y, at)};
  };
  const Function approach_of = [k](ExtendedPenalty& f, const Vector& y, double at) {
    return Vector{-f.gap_rate(k, y, at)};
  };
  const auto& dt = e.dt;
  Onset onset{k, true, e.t, rate, NAN};
  Impulse impulse{onsets_.size(), e.x[slot], {}};
  for (std::size_t c = 0; c < keys_.size(); ++c) {
    onset.drate.push_back(NAN);
    const double scale = std::max(std::abs(rate), v0_floor_);
    if (open(c)) onset.drate[c] = total(c, rate_of, e.x, e.t, carried(e, c), dt[c], scale)[0];
    impulse.slope.push_back(S_[c][slot] + dt[c] * e.before.f[slot]);
  }
  retain(k, e, -rate, approach_of, false, true);
  for (std::size_t c = 0; c < keys_.size(); ++c) {
    onset.dt.push_back(open(c) ? dt[c] : NAN);
    onset.dimpulse.push_back(NAN);
    if (!open(c)) onset.drate[c] = NAN;
    onset.reasons.push_back(reasons_[c]);
  }
  onsets_.push_back(std::move(onset));
  impulses_[static_cast<std::size_t>(k)] = std::move(impulse);
}

void PenaltyVariation::end_contact(int k, const EventMap& e) {
  const auto& d = run_.dynamics();
  const auto slot = static_cast<std::size_t>(d.impulse_offset()) + 2 * static_cast<std::size_t>(k),
             retained = static_cast<std::size_t>(d.size()) + 2 * static_cast<std::size_t>(k);
  auto& impulse = impulses_[static_cast<std::size_t>(k)];
  if (impulse) {
    auto& onset = onsets_[impulse->onset];
    onset.lasting = false;
    onset.impulse = e.x[slot] - impulse->begin;
    for (std::size_t c = 0; c < keys_.size(); ++c) {
      if (open(c)) onset.dimpulse[c] = S_[c][slot] + e.dt[c] * e.before.f[slot] - impulse->slope[c];
    }
    impulse.reset();
  }
  for (std::size_t c = 0; c < keys_.size(); ++c) S_[c][retained] = S_[c][retained + 1] = 0;
}

/// An impact on a closed contact begins or ends.
void PenaltyVariation::change_impact(int k, EventMap& e, bool jumps) {
  const auto& d = run_.dynamics();
  const auto& x = e.x;
  const double t = e.t;
  const bool begins = d.contacts()[k].in_impact;
  const double rate = probe_->gap_rate(k, x, t), w = std::sqrt(probe_->squared_touch_speed(k, x, t));
  const Function square_of = [k](ExtendedPenalty& f, const Vector& y, double at) {
    return Vector{f.squared_touch_speed(k, y, at)};
  };
  if (begins) {
    // It begins where the contact is compressed again, or where w exceeds v₀. The mass is that of this
    // instant. At its end, w does not change with time.
    const auto slot = static_cast<std::size_t>(d.size()) + 2 * static_cast<std::size_t>(k);
    const bool turns = std::abs(rate) <= located_speed * w;
    if (!turns && std::abs(w - x[slot]) > located_speed * w)
      refuse(fmt::format("t = {:.9g} s: an impact on contact {} begins between steps", t,
                         d.system().contact_facts(k).name));
    const Function value = [k, slot, turns](ExtendedPenalty& f, const Vector& y, double at) {
      return Vector{turns ? f.gap_rate(k, y, at) : f.squared_touch_speed(k, y, at) - y[slot] * y[slot]};
    };
    set_times(e, value);
  } else if (jumps) {
    refuse(fmt::format("t = {:.9g} s: the damping of contact {} jumps during contact", t,
                       d.system().contact_facts(k).name));
  }
  retain(k, e, w, square_of, true, begins);
  if (jumps) jump(e);
}

}  // namespace freeplay
