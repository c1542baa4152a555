#include "formulations/variation/step_variation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace freeplay {
namespace {

/// Relative distance from the friction limit below which a contact slips; the error of contact problems is
/// smaller.
constexpr double limit_error = 1e-6;

/// Direction of sliding at the end of a step; 0: it sticks. Of several contacts that stick, some may be at
/// their limits.
int direction(double impulse_t, double limit, double sliding, double none) {
  if (std::abs(impulse_t) < limit * (1 - limit_error) || std::abs(sliding) <= none) return 0;
  return sliding > 0 ? 1 : -1;
}

}  // namespace

StepVariation::StepVariation(EventDynamics& mode, const std::vector<VariedKey>& keys,
                             std::vector<Column> integrands, double length, double duration,
                             double position_error)
    : Variation(mode, keys, std::move(integrands), length, duration),
      mode_(mode),
      impacts_(mode.system.contacts(), position_error),
      last_closed_(static_cast<std::size_t>(mode.system.contacts()), -2 * unresolved_steps) {}

void StepVariation::start(const State& state) {
  const auto& system = mode_.system;
  x_.assign(size_, 0);
  std::ranges::copy(state.q, x_.begin());
  std::ranges::copy(state.v, x_.begin() + system.n());
  std::ranges::copy(state.z, x_.begin() + mode_.state_offset());
  for (auto& c : mode_.contacts) c.closed = false;
  for (auto& p : mode_.preloaded) p.slip = 1;
  mode_.phases.start(system, state.q.data(), state.v.data());
  mode_.measure_speeds(x_);
  at_start_ = impacts_.touching(mode_, x_, state.t, {});
}

void StepVariation::take_over(const Handover& from, const EventDynamics& mode, const Variation& events) {
  start(from.state);
  take_columns(events);
  take_varied_mode(mode_, mode);
  at_start_.clear();
  first_ = false;
  // A step of no length, whose contacts the first step compares with its own.
  last_ = Step{from.state.t, from.state.t, x_, {}, {}};
  for (int k = 0; k < mode_.system.contacts(); ++k) {
    Contact c;
    c.pressed = mode_.contacts[k].closed;
    c.slip = mode_.contacts[k].slip;
    c.t = from.contacts[static_cast<std::size_t>(k)].t_onset;
    last_->contacts.push_back(c);
    if (c.pressed) last_closed_[static_cast<std::size_t>(k)] = count_ + 1;
  }
  for (int k = 0; k < mode_.system.frictions(); ++k) last_->slips.push_back(mode_.preloaded[k].slip);
}

StepVariation::Vector StepVariation::vector_of(const MoreauStepper& stepper) const {
  const auto& system = mode_.system;
  const auto n = system.n();
  Vector x(size_);
  std::copy_n(stepper.q(), n, x.begin());
  std::copy_n(stepper.v(), n, x.begin() + n);
  std::ranges::copy(stepper.z(), x.begin() + mode_.state_offset());
  double* integral = x.data() + mode_.integral_offset();
  const auto& sums = stepper.integrals();
  integral[EventDynamics::drive] = sums.drive;
  integral[EventDynamics::load] = sums.load;
  integral[EventDynamics::damping] = sums.damping;
  integral[EventDynamics::friction_loss] = sums.friction;
  if (mode_.films.any()) integral[EventDynamics::film_loss] = sums.film;
  return x;
}

StepVariation::Step StepVariation::step_of(const MoreauStepper& stepper, double t_old) const {
  const auto& system = mode_.system;
  const double none = 1e-9 * mode_.speed_scale();
  Step s{t_old, stepper.t(), x_, {}, {}};
  for (int k = 0; k < system.contacts(); ++k) {
    const auto& c = stepper.contacts()[k];
    Contact to;
    to.pressed = c.last_n > 0;
    const auto* before = last_ ? &last_->contacts[static_cast<std::size_t>(k)] : nullptr;
    to.onset = to.pressed && !(before && before->pressed && before->t == c.t_onset);
    if (to.pressed && c.row.tangent.size > 0)
      to.slip = direction(c.last_t, *system.contact_facts(k).surface.friction * c.last_n, c.u_t_plus, none);
    to.t = c.t_onset;
    to.rate = c.u_n_minus;
    to.leaving = c.u_n_plus;
    to.impulse = c.last_n;
    s.contacts.push_back(to);
  }
  for (int k = 0; k < system.frictions(); ++k) {
    const auto& u = stepper.problem().friction(k);
    s.slips.push_back(direction(u.impulse_t, u.bound, stepper.problem().rate(u.tangent), none));
  }
  return s;
}

void StepVariation::end_step(const MoreauStepper& stepper, double t_old) {
  auto s = step_of(stepper, t_old);
  x_ = vector_of(stepper);
  if (last_) follow(*last_, &s);
  last_ = std::move(s);
}

void StepVariation::finish() {
  if (last_) follow(*last_, nullptr);
  last_.reset();
}

void StepVariation::follow(const Step& s, const Step* next) {
  ++count_;
  if (s.t == s.t_old) return;
  const bool any = std::ranges::any_of(s.contacts, [](const auto& c) { return c.onset; });
  if (idle()) {
    for (int k = 0; any && k < mode_.system.contacts(); ++k)
      if (s.contacts[static_cast<std::size_t>(k)].onset) record(s, k, "");
    return;
  }
  const double h = s.t - s.t_old;
  auto x = s.x_old;
  double t = s.t_old;
  follow_phases(x, t, h);
  follow_limits(x, t, h);
  if (first_) close_at_start(s);
  first_ = false;
  if (any) {
    begin_mode();
    t = cross_onsets(s, next, x);
  } else {
    enter_mode(s, x, t);
    t = end_sliding(s, x);
  }
  advance(x, t, s.t);
  for (std::size_t k = 0; k < last_closed_.size(); ++k)
    if (mode_.contacts[k].closed) last_closed_[k] = count_;
}

/// Projects the columns of the start onto the constraints, with contacts that are closed there without
/// approach.
void StepVariation::close_at_start(const Step& s) {
  begin_mode();
  for (const int k : at_start_) {
    const auto& c = s.contacts[static_cast<std::size_t>(k)];
    if (!c.pressed || impacts_.rate(k) < -mode_.speed_tolerance()) continue;
    mode_.contacts[k].closed = true;
    mode_.contacts[k].slip = c.slip;
  }
  for (std::size_t k = 0; k < s.slips.size(); ++k) mode_.preloaded[k].slip = s.slips[k];
  cross_at(s.x_old, {ModeEvent::Kind::none, -1, s.t_old});
}

/// Pieces of torque tables and one-way forces at the beginning of a step. Where a force jumps between them, S
/// jumps by saltation at the state of the crossing, from which it differs by the length of a step at most.
void StepVariation::follow_phases(const Vector& x, double t, double h) {
  if (!mode_.phases.any()) return;
  using Kind = ModeEvent::Kind;
  auto now = mode_.phases;
  now.start(mode_.system, x.data(), x.data() + mode_.system.n());
  for (int k = 0; k < mode_.system.phases(); ++k)
    while (true) {
      const auto &here = mode_.phases.pieces()[k], &there = now.pieces()[k];
      if (here.low == there.low && here.high == there.high) break;
      const bool up = there.low > here.low || there.high > here.high;
      const auto rest = [&](const Vector& y, double) {
        const auto w = mode_.phases.rest(mode_.system, k, up, y);
        return std::pair{w.value, w.rate};
      };
      begin_mode();
      const auto tau = root_within(x, t, 2 * h, rest);
      const auto y = tau ? flow(x, t, *tau) : x;
      const ModeEvent event{up ? Kind::phase_up : Kind::phase_down, k, t + tau.value_or(0)};
      const auto last = up ? here.high : here.low;
      mode_.phases.cross(mode_.system, {k, up, event.t});
      cross_at(y, event);
      if (!(up ? mode_.phases.pieces()[k].low >= last : mode_.phases.pieces()[k].high <= last)) break;
    }
  mode_.phases = std::move(now);
}

/// Limits of controllers that the demand has passed in the step before. The rates of their states may jump
/// there.
void StepVariation::follow_limits(const Vector& x, double t, double h) {
  using Kind = ModeEvent::Kind;
  demands_.resize(static_cast<std::size_t>(mode_.system.limiters()), NAN);
  for (int k = 0; k < mode_.system.limiters(); ++k) {
    const double now = demand(mode_, k, x, t),
                 last = std::exchange(demands_[static_cast<std::size_t>(k)], now);
    for (const double border : {-1.0, 1.0}) {
      if (!((now - border) * (last - border) < 0)) continue;
      begin_mode();
      const auto left = [&](const Vector& y, double at) {
        auto z = y;
        Vector f(size_);
        (*probe_)(y, f, at);
        add_multiple(z, 1e-6 * h, f);
        const double w = demand(mode_, k, y, at);
        return std::pair{w - border, (demand(mode_, k, z, at + 1e-6 * h) - w) / (1e-6 * h)};
      };
      const auto tau = root_within(x, t, 2 * h, left);
      const auto y = tau ? flow(x, t, *tau) : x;
      const ModeEvent event{border > 0 ? Kind::limit_up : Kind::limit_down, k, t + tau.value_or(0)};
      cross_at(y, event);
    }
  }
}

/// Whether a closed contact without an impulse in a step stays closed: its force presses it, and no flight
/// that the steps could resolve begins. Steps of other lengths, such as the last one, may leave out an
/// impulse.
bool StepVariation::stays(const Step& s, int k, const Vector& x, double t) {
  Vector f(size_);
  (*probe_)(x, f, t);
  const double rate = probe_->look(k, x, t).normal.dot(x.data() + mode_.system.n());
  return probe_->pressure(k) > 0 && rate <= unresolved_flight * probe_->pressure(k) * (s.t - s.t_old);
}

/// The mode of a step without onset. Ends of sliding follow in end_sliding().
void StepVariation::enter_mode(const Step& s, const Vector& x, double t) {
  bool more = false;
  begin_mode();
  for (std::size_t k = 0; k < s.contacts.size(); ++k) {
    auto& c = mode_.contacts[k];
    const auto& to = s.contacts[k];
    if (c.closed && !to.pressed && stays(s, static_cast<int>(k), x, t)) continue;
    more = more || (to.pressed && !c.closed);
    if (!(c.closed && to.pressed && c.slip != 0)) c.slip = to.slip;
    c.closed = to.pressed;
  }
  for (std::size_t k = 0; k < s.slips.size(); ++k)
    if (mode_.preloaded[k].slip == 0) mode_.preloaded[k].slip = s.slips[k];
  begin_mode();
  if (more) project_columns(x, t);
}

/// Passes the end of sliding in a step, at a reversal or a beginning of sticking. Returns the time reached.
double StepVariation::end_sliding(const Step& s, Vector& x) {
  using Kind = ModeEvent::Kind;
  std::vector<ModeEvent> events;
  bool turns = false;
  for (int k = 0; k < mode_.system.contacts(); ++k) {
    const auto& to = s.contacts[static_cast<std::size_t>(k)];
    if (!mode_.contacts[k].closed || !to.pressed || mode_.contacts[k].slip == to.slip) continue;
    events.push_back({Kind::slip, k, 0});
    turns = turns || to.slip != 0;
  }
  for (int k = 0; k < mode_.system.frictions(); ++k) {
    const int to = s.slips[static_cast<std::size_t>(k)];
    if (mode_.preloaded[k].slip == to) continue;
    events.push_back({Kind::slide_slip, k, 0});
    turns = turns || to != 0;
  }
  if (events.empty()) return s.t_old;
  if (events.size() > 1 && turns)
    refuse(
        fmt::format("t = {:.9g} s: several contacts reverse their sliding within one step; use a smaller "
                    "nonsmooth.step",
                    s.t_old));
  // Contacts of one body begin to stick together.
  auto& event = events[0];
  double t = s.t_old;
  const double h = s.t - s.t_old;
  const int k = event.index;
  const bool contact = event.kind == Kind::slip;
  const auto sliding = [&](const Vector& y, double at) {
    const double rate = contact ? probe_->look(k, y, at).tangent.dot(y.data() + mode_.system.n())
                                : probe_->slide_rate(k, y, at);
    Vector f(size_), z = y;
    (*probe_)(y, f, at);
    add_multiple(z, 1e-6 * h, f);
    const double later = contact ? probe_->look(k, z, at).tangent.dot(z.data() + mode_.system.n())
                                 : probe_->slide_rate(k, z, at);
    return std::pair{rate, (later - rate) / (1e-6 * h)};
  };
  const auto tau = root_within(x, t, 2 * h, sliding);
  if (!tau && turns)
    refuse(fmt::format("t = {:.9g} s: the reversal of sliding is not resolved; use a smaller nonsmooth.step",
                       t));
  advance(x, t, t + tau.value_or(0));
  event.t = t;
  begin_mode();
  for (const auto& e : events) {
    const auto place = static_cast<std::size_t>(e.index);
    if (e.kind == Kind::slip)
      mode_.contacts[e.index].slip = s.contacts[place].slip;
    else
      mode_.preloaded[e.index].slip = s.slips[place];
  }
  if (tau) cross_at(x, event);
  begin_mode();
  if (!turns) project_columns(x, t);
  return t;
}

/// S after the projection onto the present mode.
void StepVariation::project_columns(const Vector& x, double t) {
  const std::vector<int> none;
  const auto map = jump_of(none, none);
  const double speed = std::max(mode_.greatest(x.data() + mode_.system.n()), mode_.speed_scale());
  for (std::size_t c = 0; c < keys_.size(); ++c) {
    if (!open(c)) continue;
    auto slope = total(c, map, x, t, S_[c], 0, speed);
    if (!open(c)) continue;
    slope.resize(size_);
    if (peaks_.any()) peaks_.change(c, S_[c], slope);
    S_[c] = std::move(slope);
  }
}

void StepVariation::advance(Vector& x, double& t, double to) {
  if (to == t) return;
  take_knot(mode_.system, t, INFINITY);
  x = advance_watched(t, x, to - t);
  t = to;
}

}  // namespace freeplay
