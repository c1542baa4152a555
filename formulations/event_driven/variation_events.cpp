// Variation: derivatives across events.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "formulations/event_driven/event_impacts.hpp"
#include "formulations/event_driven/variation.hpp"

namespace freeplay {
namespace {

/// Least rate of an event's value, over the value and the duration: slower ones reach it tangentially.
constexpr double least_event_rate = 1e-9;
/// Change of a contact's rate by the impact of another, over that rate, from which impacts are coupled.
constexpr double coupled_share = 1e-9;
/// Change of the velocities after simultaneous impacts with their order, over the velocities before.
constexpr double order_share = 1e-9;
/// Change of a time, gap or speed by a nominal change of a parameter, over its scale: rounding.
constexpr double start_rounding = 1e-9;
/// The same, over the sum of the absolute terms of the derivative, which cancel.
constexpr double cancelled_share = 1e-6;

bool among(const std::vector<int>& list, int k) { return std::ranges::find(list, k) != list.end(); }

std::vector<double> rhs(EventDynamics& f, const std::vector<double>& x, double t) {
  std::vector<double> out(x.size());
  f(x, out, t);
  return out;
}

/// The function whose root is the event, at a state. `nominal`: in the mode before the event.
double event_value(const EventDynamics& nominal, EventDynamics& f, const ModeEvent& event,
                   const std::vector<double>& x, double t) {
  using Kind = ModeEvent::Kind;
  const int k = event.index;
  const double* v = x.data() + f.system.n();
  switch (event.kind) {
    case Kind::gap:
      return f.look(k, x, t).gap;
    case Kind::slip:
      return f.look(k, x, t).tangent.dot(v);
    case Kind::slide_slip:
      return f.slide_rate(k, x, t);
    case Kind::phase_down:
    case Kind::phase_up: {
      const auto& piece = nominal.phases.pieces()[k];
      return VariedColumns<EventDynamics>::from_kink(
          nominal.system, f.system, k, event.kind == Kind::phase_up ? piece.high : piece.low, x);
    }
    case Kind::limit_down:
    case Kind::limit_up:
      return VariedColumns<EventDynamics>::demand(f, k, x, t) - (event.kind == Kind::limit_up ? 1 : -1);
    case Kind::force:
      rhs(f, x, t);
      return f.contacts[k].lambda_n;
    case Kind::stick:
      rhs(f, x, t);
      return f.system.contact_facts(k).surface.friction_at_rest() * f.contacts[k].lambda_n -
             std::abs(f.contacts[k].lambda_t);
    case Kind::slide_stick:
      rhs(f, x, t);
      return f.preloaded[k].slack();
    case Kind::none:
      break;
  }
  return NAN;
}

}  // namespace

/// The state after the projection onto the mode and the impact, followed by the energy lost in it and
/// its impulses in the integrands.
Variation::Function Variation::jump_of(const std::vector<int>& in_impact,
                                       const std::vector<int>& ended) const {
  return [this, &in_impact, &ended](EventDynamics& f, const Vector& x, double t) {
    auto y = x;
    f.contact_loss = 0;
    f.project(y, t);
    f.measure_speeds(y);
    auto impulses = f.system.make_forces();
    if (!in_impact.empty()) {
      if (!f.apply_impact(y, t, {in_impact, ended}).empty()) std::ranges::fill(y, __builtin_nan(""));
      f.report_impact(y, in_impact, impulses);
    }
    y.push_back(f.contact_loss);
    for (const auto& c : integrands_)
      y.push_back(c.of == Column::Of::force          ? impulses.elements[c.index].*c.force
                  : c.of == Column::Of::acceleration ? impulses.acceleration[c.index]
                                                     : 0);
    return y;
  };
}

void Variation::begin_event(const EventDynamics& d) { take_mode(d); }

void Variation::cross_event(const EventDynamics& d, const ProcessedEvent& p) {
  if (on_event) on_event(d, p);
  mode_known_ = false;
  after_->take_mode(d);
  after_->knot = d.knot;
  EventMap e{p.before,
             p.t,
             side(*probe_, p.before, p.t),
             side(*after_, p.after, p.t),
             std::max(d.greatest(p.before.data() + d.system.n()), d.speed_scale()),
             Vector(keys_.size())};
  if (p.event.is_limit()) take_sides_of_limit(e, *after_, p.event.index, p.after);
  std::vector<int> onsets;
  for (const int k : p.in_impact) {
    if (probe_->contacts[k].closed) continue;
    const int slot = d.impulse_offset() + 2 * k;
    if (p.impacts.rate(k) < -d.speed_tolerance())
      onsets.push_back(k);
    else if (p.after[slot] > p.before[slot])
      refuse(
          fmt::format("t = {:.9g} s: contact {} touches another contact's impact without approach; the "
                      "motion there depends on the order of impacts",
                      p.t, d.system.contact_facts(k).name));
  }
  using Kind = ModeEvent::Kind;
  if (!onsets.empty()) {
    cross_impacts(d, p, std::move(e), onsets);
    // Contacts that others keep closed begin without an event of their own, whose time would have a
    // derivative.
    bool closes = false;
    for (int k = 0; k < d.system.contacts(); ++k)
      closes = closes || (d.contacts[k].closed && !probe_->contacts[k].closed);
    if (closes) project_columns(d, p.after, p.t);
    continued_ = false;
    return;
  }
  continued_ = false;
  if (p.event.kind == Kind::gap)
    refuse(fmt::format("t = {:.9g} s: contact {} closes without approach (grazing)", p.t,
                       d.system.contact_facts(p.event.index).name));
  if (p.event.kind != Kind::none && jumps(e.before, e.after)) set_times(e, p.event);
  jump(e, p.in_impact, p.ended);
  if (p.event.kind == Kind::none) keep_start(d, p);
}

/// dt of each column for a root of the event's function.
void Variation::set_times(EventMap& e, const ModeEvent& event) {
  const Function value = [&](EventDynamics& g, const Vector& x, double t) {
    return Vector{event_value(*probe_, g, event, x, t)};
  };
  if (event.kind == ModeEvent::Kind::gap) {
    const auto row = probe_->look(event.index, e.x, e.t).normal;
    VariedColumns::set_times(e, value, row.dot(e.x.data() + probe_->system.n()), &row, true);
    return;
  }
  const auto centre = value(*probe_, e.x, e.t);
  const auto d = along(*probe_, value, centre, e.x, e.t, e.before.f, 1, e.speed);
  const double rate = d.slope[0];
  if (!d.smooth || !(std::abs(rate) * duration_ > least_event_rate * std::abs(centre[0])))
    refuse(fmt::format("t = {:.9g} s: {} is reached tangentially", e.t,
                       event.is_phase()   ? "a kink of an element's force"
                       : event.is_limit() ? "the limit of a controller"
                                          : "a friction limit or the end of sliding"));
  VariedColumns::set_times(e, value, rate, nullptr, true);
}

/// S across an event: a jump of the state with impacts of these contacts.
void Variation::jump(const EventMap& e, const std::vector<int>& in_impact, const std::vector<int>& ended) {
  const auto &before = e.before, &after = e.after;
  const auto map = jump_of(in_impact, ended);
  const auto now = map(*probe_, e.x, e.t);
  for (std::size_t i = 0; i < integrands_.size(); ++i) integrals_[i] += now[size_ + 1 + i];
  if (peaks_.any()) add_event_peaks(e.t, e.x, before.f, now, after.f, e.dt);
  for (std::size_t c = 0; c < keys_.size(); ++c) {
    if (!open(c)) continue;
    const auto dx = carried(e, c);
    const double dt = e.dt[c];
    const auto slope = total(c, map, e.x, e.t, dx, dt, e.speed);
    if (!open(c)) continue;
    if (peaks_.any()) peaks_.jump(c, {e.x, now, dx, slope, before.f, after.f, dt});
    for (std::size_t i = 0; i < size_; ++i) S_[c][i] = slope[i] - dt * after.f[i];
    loss_[c] += slope[size_];
    for (std::size_t i = 0; i < integrands_.size(); ++i)
      integral_rates_[c][i] += slope[size_ + 1 + i] + dt * (before.integrands[i] - after.integrands[i]);
  }
  peaks_.jump(e.x, now);
}

/// Whether the impact of one of these contacts changes the rate of another.
bool Variation::coupled(const Vector& x, double t, const std::vector<int>& ended,
                        const std::vector<int>& onsets, const std::vector<int>& closed) {
  const int n = probe_->system.n();
  for (const int a : onsets) {
    auto one = closed;
    one.push_back(a);
    const auto y = jump_of(one, ended)(*probe_, x, t);
    for (const int b : onsets) {
      if (a == b) continue;
      const auto& row = probe_->look(b, x, t);
      const double *v = x.data() + n, *w = y.data() + n;
      const double change = std::max(std::abs(row.normal.dot(w) - row.normal.dot(v)),
                                     std::abs(row.tangent.dot(w) - row.tangent.dot(v)));
      if (change > coupled_share * std::abs(row.normal.dot(v))) return true;
    }
  }
  return false;
}

/// The greatest difference (m/s) between the velocities after the impacts of two contacts one by one, in
/// either order, until none approaches.
double Variation::change_by_order(const ProcessedEvent& p, int a, int b, const std::vector<int>& closed) {
  constexpr int most_impacts = 100;
  const int n = probe_->system.n();
  const std::vector<int> none;
  const auto end = [&](int k, int other) {
    auto x = p.before;
    for (int i = 0, calm = 0; i < most_impacts && calm < 2; ++i, std::swap(k, other)) {
      if (!(probe_->look(k, x, p.t).normal.dot(x.data() + n) < -probe_->speed_tolerance())) {
        ++calm;
        continue;
      }
      calm = 0;
      auto one = closed;
      one.push_back(k);
      std::ranges::sort(one);
      x = jump_of(one, none)(*probe_, x, p.t);
      x.resize(size_);
    }
    return x;
  };
  auto x = end(a, b);
  add_multiple(x, -1, end(b, a));
  return probe_->greatest(x.data() + n);
}

void Variation::cross_impacts(const EventDynamics& d, const ProcessedEvent& p, EventMap e,
                              const std::vector<int>& onsets) {
  const int n = d.system.n();
  std::vector<int> closed;
  for (const int k : p.in_impact)
    if (probe_->contacts[k].closed) closed.push_back(k);
  const bool wanted = std::ranges::any_of(reasons_, [](const auto& r) { return r.empty(); });
  if (onsets.size() > 1 && wanted) {
    const bool stays = std::ranges::any_of(onsets, [&](int k) { return d.contacts[k].closed; });
    if (stays || coupled(p.before, p.t, p.ended, onsets, closed)) {
      const double change = change_by_order(p, onsets[0], onsets[1], closed);
      refuse(fmt::format(
          "t = {:.9g} s: contacts {} and {} have simultaneous impacts that act on each other; {}", p.t,
          d.system.contact_facts(onsets[0]).name, d.system.contact_facts(onsets[1]).name,
          change > order_share * probe_->greatest(p.before.data() + n)
              ? fmt::format(
                    "the velocities after them change by {:.2g} m/s with their order, so that there are "
                    "no one-sided derivatives either",
                    change)
              : "the derivatives are one-sided"));
    }
  }
  auto x = p.before;
  for (std::size_t i = 0; i < onsets.size(); ++i) {
    const int k = onsets[i];
    const double rate = probe_->look(k, p.before, p.t).normal.dot(p.before.data() + n);
    refuse_grazing(k, e, rate, probe_->gap_acceleration(k, p.before, p.t));
    approaching_.assign(1, k);
    std::ranges::fill(e.dt, 0.0);
    set_times(e, {ModeEvent::Kind::gap, k, p.t});
    const auto& dt = e.dt;
    if (p.event.kind == ModeEvent::Kind::none && !continued_)
      for (std::size_t c = 0; c < keys_.size(); ++c)
        if (std::abs(dt[c]) * keys_[c].scale() > start_rounding * duration_)
          refuse(c, fmt::format("t = {:.9g} s: contact {} closes at the start, so that {} has only a "
                                "one-sided derivative",
                                p.t, d.system.contact_facts(k).name, keys_[c].name));
    // The derivatives of time, approach rate and impulse.
    const int slot = d.impulse_offset() + 2 * k;
    Onset onset{k, d.contacts[k].closed, p.t + p.impacts.ending(k), p.impacts.rate(k),
                p.after[slot] - p.before[slot]};
    const Function rate_of = [&](EventDynamics& f, const Vector& y, double t) {
      return Vector{f.look(k, y, t).normal.dot(y.data() + n)};
    };
    auto one = closed;
    one.push_back(k);
    std::ranges::sort(one);
    // Remaining time of an accumulation of bounces (event_impacts.hpp).
    const std::vector<int> none;
    const auto bounce = jump_of(one, none);
    const Function remaining = [&](EventDynamics& f, const Vector& y, double t) {
      auto z = bounce(f, y, t);
      z.resize(y.size());
      const double u = f.look(k, z, t).normal.dot(z.data() + n), e = -u / rate_of(f, y, t)[0];
      return Vector{-2 * u / f.gap_acceleration(k, z, t) / (1 - e)};
    };
    const bool ends = among(p.ended, k);
    const auto was = S_;
    for (std::size_t c = 0; c < keys_.size(); ++c) {
      onset.dt.push_back(dt[c]);
      onset.drate.push_back(NAN);
      if (!open(c)) continue;
      const auto dx = carried(e, c);
      // Kinks of the impact are found by jump().
      onset.drate[c] = total(c, rate_of, p.before, p.t, dx, dt[c], e.speed, false)[0];
      if (ends) onset.dt[c] += total(c, remaining, p.before, p.t, dx, dt[c], e.speed, false)[0];
    }
    // Between uncoupled impacts the mode is the one before.
    auto y = jump_of(one, p.ended)(*probe_, x, p.t);
    y.resize(size_);
    EventMap one_by_one{x,
                        p.t,
                        i == 0 ? e.before : side(*probe_, x, p.t),
                        i + 1 == onsets.size() ? e.after : side(*probe_, y, p.t),
                        e.speed,
                        dt};
    const auto &here = one_by_one.before, &next = one_by_one.after;
    const auto error = impact_error ? impact_error(k) : ImpactError();
    for (double& time : one_by_one.dt) time += error.delay;
    jump(one_by_one, one, p.ended);
    for (std::size_t c = 0; c < keys_.size() && error.excess != 0; ++c)
      for (std::size_t j = 0; j < static_cast<std::size_t>(n) && open(c); ++j)
        S_[c][n + j] += error.excess * (y[n + j] - x[n + j]);
    for (std::size_t c = 0; c < keys_.size(); ++c) {
      const bool known = open(c);
      onset.dimpulse.push_back(known && !onset.lasting
                                   ? S_[c][slot] + dt[c] * next.f[slot] - was[c][slot] - dt[c] * here.f[slot]
                                   : NAN);
      if (!known) onset.dt[c] = onset.drate[c] = NAN;
      onset.reasons.push_back(reasons_[c]);
    }
    onsets_.push_back(std::move(onset));
    x = y;
  }
  approaching_.clear();
}

/// At a start or knot, contacts close that were open before: S must keep them closed. Otherwise the
/// neighbouring motions separate or approach on one side.
void Variation::keep_start(const EventDynamics& d, const ProcessedEvent& p) {
  const int n = d.system.n();
  const auto check = [&](const char* what, const std::string& name, const Function& value,
                         const SparseRow& row, bool rates) {
    const auto centre = value(*probe_, p.after, p.t);
    double weight = 0;
    const double speed = std::max(d.greatest(p.after.data() + n), d.speed_scale());
    for (std::size_t c = 0; c < keys_.size(); ++c) {
      if (!open(c)) continue;
      weight = 0;
      for (int i = 0; i < row.size; ++i)
        weight += std::abs(row.value[i] * S_[c][(rates ? n : 0) + row.column[i]]);
      const auto a = along(*probe_, value, centre, p.after, p.t, S_[c], 0, speed).slope[0];
      const auto b = across(c, value, centre, p.after, p.t).slope[0];
      if (std::abs(a + b) > cancelled_share * (weight + std::abs(b)) &&
          std::abs(a + b) * keys_[c].scale() > start_rounding * (rates ? speed : length_))
        refuse(c, fmt::format("t = {:.9g} s: {} of {} changes with {} at the start of contact, so that there "
                              "is only a one-sided derivative",
                              p.t, what, name, keys_[c].name));
    }
  };
  for (int k = 0; k < d.system.contacts(); ++k) {
    const auto& contact = d.contacts[k];
    if (!contact.closed || probe_->contacts[k].closed) continue;
    const auto row = probe_->look(k, p.after, p.t);
    const auto& name = d.system.contact_facts(k).name;
    check(
        "the gap", name,
        [k](EventDynamics& f, const Vector& x, double t) { return Vector{f.look(k, x, t).gap}; }, row.normal,
        false);
    check(
        "the gap rate", name,
        [k, n](EventDynamics& f, const Vector& x, double t) {
          return Vector{f.look(k, x, t).normal.dot(x.data() + n)};
        },
        row.normal, true);
    if (row.tangent.size == 0 || std::abs(row.tangent.dot(p.after.data() + n)) > d.slide_tolerance())
      continue;
    check(
        "the sliding rate", name,
        [k, n](EventDynamics& f, const Vector& x, double t) {
          return Vector{f.look(k, x, t).tangent.dot(x.data() + n)};
        },
        row.tangent, true);
  }
  for (int k = 0; k < d.system.frictions(); ++k) {
    if (std::abs(probe_->slide_rate(k, p.after, p.t)) > d.preloaded[k].share * d.slide_tolerance() ||
        (probe_->preloaded[k].slip == 0 && d.preloaded[k].slip == 0))
      continue;
    check(
        "the sliding rate", d.system.friction_facts(k).name,
        [k](EventDynamics& f, const Vector& x, double t) { return Vector{f.slide_rate(k, x, t)}; },
        probe_->preloaded[k].row, true);
  }
}

}  // namespace freeplay
