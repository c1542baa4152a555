#include "formulations/event_driven/event_driven.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "formulations/integrators/curve_limit.hpp"
#include "formulations/integrators/tolerance.hpp"

namespace freeplay {

EventDriven::EventDriven(EventDynamics dynamics, Method method, Method coarse, double time_scale,
                         double position_error)
    : dynamics_(std::move(dynamics)),
      method_(std::move(method)),
      coarse_(std::move(coarse)),
      time_scale_(time_scale),
      span_(0.1 * time_scale),
      position_error_(position_error) {
  const auto contacts = static_cast<std::size_t>(dynamics_.system().contacts());
  mark_.resize(contacts);
  for (auto* x : {&ending_, &rate_before_, &slide_before_}) x->resize(contacts);
  scratch_.resize(dynamics_.size());
  slope_.resize(dynamics_.size());
}

void EventDriven::start(const State& state, ContactLog& log) {
  log_ = &log;
  std::ranges::fill(scratch_, 0);
  std::ranges::copy(state.q, scratch_.begin());
  std::ranges::copy(state.v, scratch_.begin() + dynamics_.system().n());
  std::ranges::copy(state.z, scratch_.begin() + dynamics_.state_offset());
  for (auto& c : dynamics_.contacts()) c.closed = false;
  for (auto& p : dynamics_.preloaded()) p.slip = 1;  // any mode: the true one is chosen before the first step
  dynamics_.phases.start(dynamics_.system(), state.q.data(), state.v.data());
  dynamics_.forget_place();
  method_.start(dynamics_, state.t, scratch_);
  last_ = {};
  pending_ = true;
}

bool EventDriven::is_finite() const {
  return std::ranges::all_of(method_.x, [](double x) { return std::isfinite(x); });
}

/// The state stays one that is finite: else the one before the step.
bool EventDriven::fail(const std::string& what) {
  if (!is_finite()) {
    method_.x = finite_;
    method_.t = finite_t_;
  }
  failure_ = fmt::format("t = {:.9g} s: {}", method_.t, what);
  return false;
}

/// The state within the last step.
const std::vector<double>& EventDriven::at(double t) const {
  if (t >= method_.t) return method_.x;
  method_.interpolate(t, scratch_);
  return scratch_;
}

void EventDriven::interpolate(double t, double* q, double* v) const {
  const int n = dynamics_.system().n();
  const auto& x = at(t);
  std::copy(x.begin(), x.begin() + n, q);
  std::copy(x.begin() + n, x.begin() + 2 * n, v);
}

void EventDriven::watch_forces(bool on) {
  watching_ = on;
  if (on && !probe_) make_probe();
}

void EventDriven::make_probe() {
  probe_ = dynamics_.twin();
  before_step_ = within_ = strike_ = force_ = dynamics_.system().make_forces();
}

/// The mode of the last step lasts until the next one begins.
void EventDriven::forces(double t, Forces& out) {
  probe_->take_mode(dynamics_);
  probe_->report(at(t), t, out);
}

bool EventDriven::step(double t_end) {
  finite_ = method_.x;
  finite_t_ = method_.t;
  if (watching_) {
    before_step_.clear();
    within_.clear();
  }
  const double knot = dynamics_.system().next_knot(method_.t);
  const bool jumps = dynamics_.system().has_motions();
  if (jumps) dynamics_.knot = std::nextafter(knot, method_.t);
  if (pending_) {
    if (gives_way_) keep_mode();
    if (!change_mode()) {
      if (gives_way_) give_back_mode();
      return false;
    }
  }
  // No step crosses a kink of a curve in time, or jumps over what a curve does.
  t_end = std::min({t_end, knot, method_.t + longest_step(dynamics_.system(), v()),
                    method_.t + curve_step_limit(dynamics_.system(), method_.t, q(), v(), Knots::located)});
  watch(method_.x, before_);
  bool stepped = method_.step(dynamics_, t_end);
  if (!stepped && dynamics_.jammed() && last_jam_ < method_.t) {  // sliding jams just ahead
    method_.unshift();
    last_jam_ = method_.t;
    std::vector<int> touching;
    for (int k = 0; k < dynamics_.system().contacts(); ++k)
      if (dynamics_.contacts()[k].closed) touching.push_back(k);
    if (!jam(touching)) return false;
    method_.start(dynamics_, method_.t, std::vector<double>(method_.x));
    mark_gaps(true);
    watch(method_.x, before_);
    stepped = method_.step(dynamics_, t_end);
  }
  if (!stepped)
    return fail(dynamics_.trouble().empty()
                    ? "no step is accepted any more, however small; the motion is singular there, or "
                      "nonsmooth.tolerance beyond rounding"
                    : dynamics_.trouble());
  Event first = shorten_until_bounded();
  ++dynamics_.work.steps;
  dynamics_.work.rejected = method_.rejected;
  find_mode_events(first);
  find_phase_events(first);
  last_ = first;
  pending_ = first.kind != Event::Kind::none;
  if (pending_)
    land_on_first(
        method_, last_, [this](Event& event) { land(event); },
        [this](const Event&) {
          Event lost;
          lost.t = method_.t;
          find_gap_events(lost);
          unseen_ = std::max(unseen_, step_unseen_);
          return lost;
        });
  if (!is_finite()) return fail("the state is no longer finite");
  if (!pending_) {
    dynamics_.project(method_.x, method_.t, watching_ ? &within_ : nullptr);
    method_.renew(dynamics_);
  }
  mark_gaps();
  dynamics_.keep_extremes(method_.x, method_.t);
  if (!pending_ && jumps && method_.t >= knot) {  // the mode is chosen anew
    last_ = {};
    pending_ = true;
    return true;
  }
  return !pending_ || paced();
}

/// The first loss of a gap in the last step, which is made again, shorter, while it took a curve's argument further than it
/// may, as a body that came to speed does, or while it is so long that nothing bounds how a gap bends in it, or that it leaves open
/// whether a gap was lost.
EventDriven::Event EventDriven::shorten_until_bounded() {
  int halvings = 0;
  for (int tries = 0;; ++tries) {
    Event first;
    first.t = method_.t;
    double over = curve_overreach(dynamics_.system(), method_.t_old, method_.x_old.data(), v_old(), method_.t,
                                  q(), v(), Knots::located);
    if (!(over > most_overreach)) {
      if ((find_gap_events(first) && (step_unseen_ <= seen_depth || halvings++ == most_halvings)) ||
          !is_finite()) {
        unseen_ = std::max(unseen_, step_unseen_);
        return first;
      }
      over = 2;
    }
    if (tries == 60) return first;
    ++method_.rejected;
    method_.land(dynamics_, method_.t_old + (method_.t - method_.t_old) / over);
    method_.limit_step(2 * (method_.t - method_.t_old));
  }
}

/// Whether time goes on: a thousand events in next to no time, or some ten thousands in a small part of the time in
/// which anything moves, are no motion that this scheme can follow.
bool EventDriven::paced() {
  constexpr long window = 10'000, most = 3;
  if (++recent_ % 1000 == 0) {
    if (method_.t - recent_since_ < 1e-3 * time_scale_)
      return fail(fmt::format(
          "1000 impacts and changes of contact within {:.2g} s: they follow each other too fast to be told one by "
          "one; time stepping passes them",
          method_.t - recent_since_));
    recent_since_ = method_.t;
  }
  if (recent_ % window != 0) return true;
  const double passed = method_.t - window_since_;
  window_since_ = method_.t;
  slow_windows_ = passed < 0.2 * time_scale_ ? slow_windows_ + 1 : 0;
  if (slow_windows_ < most) return true;
  return fail(fmt::format(
      "the last {} impacts and changes of contact took {:.2g} s; at this pace {:.2g} of them make a second: more than "
      "can be told one by one; time stepping passes them",
      window, passed, static_cast<double>(window) / passed));
}

/// Impacts where something approaches, then the mode that the accelerations choose.
bool EventDriven::change_mode() {
  pending_ = false;
  if (pace_length_ > 0) {
    time_scale_ = std::min(time_scale_, pace_length_ / greatest_speed(dynamics_.system(), v()));
    span_ = 0.1 * time_scale_;
  }
  if (last_.kind == Event::Kind::phase_up || last_.kind == Event::Kind::phase_down) {
    dynamics_.phases.cross(dynamics_.system(), {last_.index, last_.kind == Event::Kind::phase_up, method_.t});
    dynamics_.forget_place();
  }
  const double t = method_.t;
  auto& d = dynamics_;
  auto& x = method_.x;
  auto* const book = watching_ ? &before_step_ : nullptr;
  d.project(x, t,
            book);  // within a step closed contacts drift by its error: what holds must not seem to leave
  d.measure_speeds(x);
  // What holds at its bound is torn, and all that holds there with it: feet of one body give way together.
  if (!d.together() && (last_.kind == Event::Kind::stick || last_.kind == Event::Kind::slide_stick)) {
    const auto torn = [&](double force, double bound, bool this_one) {
      return this_one || std::abs(force) >= bound * (1 - 1e-7) ? (force > 0 ? -1 : 1) : 0;
    };
    for (int k = 0; k < d.system().contacts(); ++k) {
      auto& c = d.contacts()[k];
      if (!c.closed || c.slip != 0 || c.tangent_unknown < 0) continue;
      c.forced = torn(c.lambda_t, *d.system().contact_facts(k).surface.friction * c.lambda_n,
                      last_.kind == Event::Kind::stick && last_.index == k);
    }
    for (int k = 0; k < d.system().frictions(); ++k) {
      auto& p = d.preloaded()[k];
      if (p.slip == 0)
        p.forced = torn(p.lambda, p.bound, last_.kind == Event::Kind::slide_stick && last_.index == k);
    }
  }

  std::vector<int> touching, was_closed;
  for (int k = 0; k < d.system().contacts(); ++k) {
    const bool closed = d.contacts()[k].closed;
    if (closed) was_closed.push_back(k);
    const auto& row = d.look(k, x, t);
    rate_before_[k] = row.normal.dot(v());
    slide_before_[k] = row.tangent.dot(v());
    ending_[k] = 0;
    const bool here = last_.kind == Event::Kind::gap && last_.index == k;
    const double near =
        std::max({1e-10 * d.system().contact_facts(k).clearance, position_error_, 8 * rounding(k)}) +
        1e-14 * d.system().longest_arm();
    // What leaves takes part where contacts strike each other to and fro at one instant: without approach it is only
    // kept from approaching.
    const bool crowded = hurried_ || crowd_ >= 8;
    if (closed || here ||
        (row.normal.size > 0 && row.gap <= near && (crowded || rate_before_[k] <= d.speed_tolerance())))
      touching.push_back(k);
  }
  if (!settle_together()) return false;
  kicked_.clear();
  if (!impacts(touching) || !choose(touching)) return false;
  d.mend();
  const double kinetic = d.system().kinetic(v());
  const double stabilised = d.stabilisation;
  d.project(x, t, book);
  if (hurried_ && !kicked_.empty()) {  // their speeds are lost with the hops that are left out
    d.contact_loss += kinetic - d.system().kinetic(v());
    d.stabilisation = stabilised;
    ended_.take(kicked_.size(), ending_, kinetic - d.system().kinetic(v()));
  }
  record(was_closed);
  method_.start(d, t, std::vector<double>(x));
  mark_gaps(true);
  return true;
}

/// From now on all that touches is decided together, with the integrator for that; the mode begins anew.
bool EventDriven::decide_together() {
  if (dynamics_.together()) return true;
  if (gives_way_)
    return fail(hurried_ ? "contacts kick each other too fast to be told one by one"
                         : "modes of contact change again and again");
  dynamics_.set_together(true);
  together_since_ = method_.t;
  const double t = method_.t;
  const std::vector<double> x = method_.x;
  const long rejected = method_.rejected;
  method_ = coarse_;
  is_coarse_ = true;
  method_.rejected = rejected;
  method_.begin(t, x);
  return true;
}

/// Modes that change again and again, faster than anything moves, are decided together from
/// then on.
bool EventDriven::settle_together() {
  constexpr int most = 16;
  const double t = method_.t;
  if (last_.kind == Event::Kind::gap || last_.kind == Event::Kind::none) return true;
  if (changes_ == 0 || t - changes_since_ > 1e-6 * time_scale_) {
    changes_ = 0;
    changes_since_ = t;
  }
  return ++changes_ < most || decide_together();
}

/// The mode. Contacts whose force has just come to zero open, unless what presses them then closes them.
bool EventDriven::choose(std::vector<int>& touching) {
  auto& d = dynamics_;
  const auto& x = method_.x;
  if (last_.kind == Event::Kind::force && !d.together()) {
    const double none = std::max(1e-6 * d.acceleration_scale(), 1e-9 * d.centripetal_scale(v()));
    auto pressed = touching;
    std::erase_if(pressed, [&](int k) { return d.contacts()[k].closed && d.pressure(k) <= none; });
    if (pressed.size() < touching.size()) {
      const auto open = [&](int k) {
        return std::ranges::find(pressed, k) != pressed.end() || d.gap_acceleration(k, x, method_.t) >= -none;
      };
      const auto reason = d.choose(x, method_.t, pressed);
      if (!reason.empty() && !d.jammed()) return fail(reason);
      if (!d.jammed() && std::ranges::all_of(touching, open)) {
        touching = pressed;
        return true;
      }
    }
  }
  auto reason = d.choose(x, method_.t, touching);
  // What was torn must slide the way it was torn. Where it barely does not, the projection took it back below its bound, by the
  // error of the step that led there: it holds on. Else only all together can tell what gives way.
  if (!d.together() && d.torn()) {
    constexpr double none = 1e-9, little = 1e-6;
    const double back = reason.empty() ? d.torn_back(x, method_.t) : std::numeric_limits<double>::infinity();
    if (back > none) {
      d.mend();
      if (back > little && !decide_together()) return false;
      reason = d.choose(x, method_.t, touching);
    }
  }
  return reason.empty() || (d.jammed() && touching.size() > 1 ? jam(touching) : fail(reason));
}

/// What slides admits no finite forces, or none that are found: sliding ends by an impact without collision (Génot and Brogliato, Eur. J.
/// Mech. A/Solids 18 (1999) 653), and the mode is chosen anew. One contact alone stops the run: its scene is
/// about that.
bool EventDriven::jam(std::vector<int>& touching) {
  auto& d = dynamics_;
  if (gives_way_)
    return fail(d.jam_proved() ? "friction admits no finite force on what slides (Painlevé)"
                               : "no solver finds forces that friction admits on what slides");
  bool proved = true;
  for (int tries = 0; tries < 3; ++tries) {
    const double kinetic = d.system().kinetic(v());
    auto& kind = d.jam_proved() ? jams_ : unsolved_;
    proved = proved && d.jam_proved();
    if (const auto reason = d.strike(method_.x, method_.t, touching, touching, true); !reason.empty())
      return fail(reason);
    if (watching_) {
      d.report_strike(method_.x, touching, strike_);
      before_step_.add(1, strike_);
    }
    kind.take(1, ending_, kinetic - d.system().kinetic(v()));
    std::erase_if(touching,
                  [&](int k) { return d.look(k, method_.x, method_.t).normal.dot(v()) > 2 * d.jam_rate(); });
    const auto reason = d.choose(method_.x, method_.t, touching);
    if (reason.empty()) return true;
    if (!d.jammed()) return fail(reason);
  }
  return fail(
      proved
          ? "friction admits no acceleration (Painlevé), and three impacts without collision do not end that"
          : "no solver finds accelerations that friction admits, and three impacts without collision do not "
            "end that; whether there are any is not known");
}

/// Solves the impact of the touching contacts if one approaches; leaves in `touching` those that stay.
bool EventDriven::impacts(std::vector<int>& touching) {
  auto& d = dynamics_;
  const double tiny = d.speed_tolerance(), t = method_.t;
  if (std::ranges::none_of(touching, [&](int k) { return rate_before_[k] < -tiny; })) {
    auto staying = touching;
    // What was closed does not leave by its drift, but by its force.
    const auto held = [&](int k) {
      return d.contacts()[k].closed && !(last_.kind == Event::Kind::force && last_.index == k);
    };
    std::erase_if(staying, [&](int k) { return rate_before_[k] > tiny && !held(k); });
    // One whose gap closed within rounding while it opened: if what it does is no hop, it has not left.
    const int k = last_.kind == Event::Kind::gap ? last_.index : -1;
    if (k >= 0 && std::ranges::find(staying, k) == staying.end()) {
      const auto reason = d.choose(method_.x, t, staying);
      if (!reason.empty() && !d.jammed()) return fail(reason);
      const double g = d.jammed() ? 0 : d.gap_acceleration(k, method_.x, t), u = rate_before_[k];
      if (g < 0 && 0.5 * u * u / -g <= least_hop(k)) staying.push_back(k);
      std::ranges::sort(staying);
    }
    touching = staying;
    return true;
  }
  // Struck at once with the one whose gap came to zero.
  if (touching.size() > 1)
    for (const int k : touching)
      if (!d.contacts()[k].closed && rate_before_[k] < -tiny)
        merged_ = std::max(merged_, std::abs(d.look(k, method_.x, t).gap));
  crowd_ = t - last_impact_ <= 1e-6 * span_ ? crowd_ + 1 : 0;
  last_impact_ = t;
  const auto before = method_.x;
  const double loss_before = d.contact_loss;
  Unloaded unloaded;
  const auto strike = [&](const std::vector<int>& soft) {
    auto reason = d.strike(method_.x, t, touching, soft);
    if (reason.empty()) unloaded = unloaded_in(touching);
    if (watching_ && reason.empty()) d.report_strike(method_.x, touching, strike_);
    return reason;
  };
  if (const auto reason = strike({}); !reason.empty()) return fail(reason);
  const auto leaving = [&](int k) { return d.look(k, method_.x, t).normal.dot(v()) > tiny; };
  auto staying = touching;
  std::erase_if(staying, leaving);
  if (!count_impact(touching)) return false;
  std::vector<int> over;
  // One pass, or, where contacts kick each other, until no more of them is over.
  for (std::size_t round = 0; round <= touching.size(); ++round) {
    const auto known = over.size();
    kicked_.clear();
    if (!ending_contacts(touching, staying, over)) return false;
    if (over.size() == known) break;
    const double kinetic = d.system().kinetic(v());
    method_.x = before;
    d.contact_loss = loss_before;
    if (const auto reason = strike(over); !reason.empty()) return fail(reason);
    staying = touching;
    std::erase_if(staying, leaving);
    if (!hurried_ && touching.size() < 3) break;
    if (hurried_) ended_.take(over.size() - known, ending_, kinetic - d.system().kinetic(v()));
  }
  if (watching_) before_step_.add(1, strike_);
  unloaded_.take(unloaded);
  const double kinetic = d.system().kinetic(before.data() + d.system().n());
  if (d.struck_inelastic()) inelastic_.take(1, ending_, kinetic - d.system().kinetic(v()));
  d.extremes.count_gain(d.impact_gain(), kinetic, 1e-12);
  for (const int k : kicked_)
    if (std::ranges::find(staying, k) == staying.end()) staying.push_back(k);
  std::ranges::sort(staying);
  touching = staying;
  return true;
}

/// Of the contacts of the last strike those that neither approached nor bore a load before it, and have an impulse in it. An
/// impact without them would leave them approaching: whether their gaps are zero decides the motion.
EventDriven::Unloaded EventDriven::unloaded_in(const std::vector<int>& struck) const {
  const auto& d = dynamics_;
  double greatest = 0;
  for (const int k : struck) greatest = std::max(greatest, std::abs(rate_before_[k]));
  Unloaded found;
  for (std::size_t i = 0; i < struck.size(); ++i) {
    const int k = struck[i];
    const bool located = last_.kind == Event::Kind::gap && last_.index == k;
    if (d.contacts()[k].closed || located || rate_before_[k] < -d.speed_tolerance() ||
        d.struck_rate(i) <= 1e-9 * greatest)
      continue;
    if (found.count++ == 0) {
      found.contact = k;
      found.t = method_.t;
    }
    found.gap = std::max(found.gap, std::abs(d.contacts()[k].row.gap));
  }
  return found;
}

/// Impacts that follow each other faster than a number in a span, which contacts that kick each other keep up
/// for ever.
bool EventDriven::count_impact(const std::vector<int>& touching) {
  constexpr int most = 100;
  const double t = method_.t;
  if (t - block_since_ > span_) {
    hurried_ = hurried_ && block_ >= most / 4 && t - block_since_ < 2 * span_;
    block_ = 0;
    block_since_ = t;
    struck_first_ = -1;
    several_ = false;
  }
  // One contact alone has an end that is known exactly; only several kick each other.
  for (int k = 0; k < dynamics_.system().contacts(); ++k)
    if (rate_before_[k] < -dynamics_.speed_tolerance() && std::ranges::find(touching, k) != touching.end()) {
      if (struck_first_ < 0) struck_first_ = k;
      several_ = several_ || k != struck_first_;
    }
  ++block_;
  hurried_ = hurried_ || (several_ && block_ >= most);
  // What is left of speeds where hops are cut short is no sliding: modes are decided together.
  if (hurried_ && !decide_together()) return false;
  most_kinetic_ = std::max(most_kinetic_, dynamics_.system().kinetic(v()));
  return true;
}

/// Of the struck contacts that leave again, those whose hops are over, with the time left in ending_.
bool EventDriven::ending_contacts(const std::vector<int>& struck, const std::vector<int>& staying,
                                  std::vector<int>& over) {
  auto& d = dynamics_;
  auto held = staying;
  decided_ = staying;
  // What is held to stay may press others to stay, as a peg presses a wall that alone carries nothing: until none is added.
  for (std::size_t round = 0; round < struck.size(); ++round) {
    bool chosen = false, added = false;
    for (const int k : struck) {
      if (std::ranges::find(held, k) != held.end()) continue;
      const double u = d.look(k, method_.x, method_.t).normal.dot(v());
      // What was struck without restitution already, and leaves still, is thrown off by its neighbours.
      const bool bounced = rate_before_[k] < -d.speed_tolerance() && std::ranges::find(over, k) == over.end();
      const double e = bounced ? u / -rate_before_[k] : 0;  // else another impact kicked it off
      if (!(e < 1)) continue;
      if (!chosen)
        if (const auto reason = d.choose(method_.x, method_.t, decided_); !reason.empty()) {
          if (d.jammed()) return true;  // nothing is known of what would press: no hop ends here
          return fail(reason);
        }
      chosen = true;
      const double g = d.gap_acceleration(k, method_.x, method_.t);
      if (!(g < 0)) continue;
      const bool low = 0.5 * u * u / -g <= least_hop(k),
                 brief = hurried_ && d.contacts()[k].restitution < 1 && 2 * u / -g <= span_;
      if (!low && !brief) continue;
      (bounced ? over : kicked_).push_back(k);
      ending_[k] = bounced ? 2 * u / -g / (1 - e) : 0;
      held.push_back(k);
      added = true;
    }
    if (!added) break;
    std::ranges::sort(held);
    decided_ = held;
  }
  return true;
}

EnergyLedger EventDriven::integrals() const {
  const double* w = method_.x.data() + dynamics_.integral_offset();
  EnergyLedger l;
  l.drive = w[EventDynamics::drive];
  l.load = w[EventDynamics::load];
  l.damping = w[EventDynamics::damping];
  l.friction = w[EventDynamics::friction_loss];
  if (dynamics_.has_films()) l.film = w[EventDynamics::film_loss];
  l.contact = dynamics_.contact_loss;
  l.stabilisation = dynamics_.stabilisation;
  return l;
}

}  // namespace freeplay
