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
      search_(dynamics_),
      impacts_(dynamics_.system.contacts(), position_error),
      pace_(time_scale),
      onsets_(static_cast<std::size_t>(dynamics_.system.contacts())) {}

void EventDriven::start(const State& state, ContactLog& log) {
  log_ = &log;
  std::vector<double> x(static_cast<std::size_t>(dynamics_.size()));
  std::ranges::copy(state.q, x.begin());
  std::ranges::copy(state.v, x.begin() + dynamics_.system.n());
  std::ranges::copy(state.z, x.begin() + dynamics_.state_offset());
  for (auto& c : dynamics_.contacts) c.closed = false;
  // any mode: the actual one is determined before the first step
  for (auto& p : dynamics_.preloaded) p.slip = 1;
  dynamics_.phases.start(dynamics_.system, state.q.data(), state.v.data());
  dynamics_.forget_place();
  method_.start(dynamics_, state.t, x);
  last_ = {};
  pending_ = true;
}

/// Keeps the state finite: if it is not, the state before the step is restored.
bool EventDriven::fail(const std::string& what) {
  if (!is_finite(method_.x)) {
    method_.x = finite_;
    method_.t = finite_t_;
  }
  failure_ = fmt::format("t = {:.9g} s: {}", method_.t, what);
  return false;
}

/// Failure because event-driven integration cannot resolve the motion.
bool EventDriven::beyond(const std::string& what) {
  return fail(hands_over_ ? what : what + "; use nonsmooth.scheme = \"automatic\"");
}

void EventDriven::interpolate(double t, double* q, double* v) const {
  const int n = dynamics_.system.n();
  const auto& x = search_.at(method_, t);
  std::copy(x.begin(), x.begin() + n, q);
  std::copy(x.begin() + n, x.begin() + 2 * n, v);
}

bool EventDriven::step(double t_end) {
  auto& d = dynamics_;
  finite_ = method_.x;
  finite_t_ = method_.t;
  forces_.clear();
  const double knot = d.system.next_knot(method_.t);
  const bool jumps = d.system.has_motions();
  if (jumps) d.knot = std::nextafter(knot, method_.t);
  if (pending_) {
    if (hands_over_) keep_mode();
    if (!change_mode()) {
      if (hands_over_) give_back_mode();
      return false;
    }
  }
  // No step crosses a kink of a curve in time or passes over a feature of a curve.
  t_end = std::min({t_end, knot, method_.t + longest_step(d.system, v()),
                    method_.t + curve_step_limit(d.system, method_.t, q(), v(), Knots::located)});
  if (!step_until_lockup(t_end)) return false;
  last_ = search_.find(d, method_);
  pending_ = last_.kind != ModeEvent::Kind::none;
  span_ = std::max(method_.t - method_.t_old, 0.5 * span_);
  if (pending_) search_.land(d, method_, last_);
  if (!is_finite(method_.x)) return fail("the state is no longer finite; use a smaller nonsmooth.tolerance");
  if (variation_) {
    if (method_.relieved())
      variation_->refuse("the implicit method has taken over because of films; it has no derivatives");
    variation_->advance(d, method_.t_old, method_.x_old, method_.t);
  }
  if (!pending_) {
    d.project(method_.x, method_.t, forces_.impulses_within());
    method_.renew(d);
  }
  search_.mark_gaps(d, method_);
  d.keep_extremes(method_.x, method_.t);
  if (!pending_ && jumps && method_.t >= knot) {  // the mode is determined anew
    last_ = {};
    pending_ = true;
    return true;
  }
  if (!pending_) return true;
  const auto reason = pace_.event(method_.t);
  return reason.empty() || beyond(reason);
}

/// Makes a step of the method. If sliding locks up just ahead, the sliding is ended first.
bool EventDriven::step_until_lockup(double t_end) {
  auto& d = dynamics_;
  search_.begin(d, method_.x);
  bool stepped = method_.step(d, t_end);
  if (!stepped && d.locked_up() && last_lockup_ < method_.t) {
    method_.unshift();
    last_lockup_ = method_.t;
    std::vector<int> touching;
    for (int k = 0; k < d.system.contacts(); ++k)
      if (d.contacts[k].closed) touching.push_back(k);
    if (!end_lockup(touching)) return false;
    method_.start(d, method_.t, std::vector<double>(method_.x));
    search_.mark_gaps(d, method_, true);
    search_.begin(d, method_.x);
    stepped = method_.step(d, t_end);
  }
  return stepped ||
         fail(d.trouble.empty() ? "every step is rejected, however small: the motion is singular there, or "
                                  "nonsmooth.tolerance is below rounding error"
                                : d.trouble);
}

/// Solves impacts if contacts approach, then determines the mode from the accelerations.
bool EventDriven::change_mode() {
  auto& d = dynamics_;
  auto& x = method_.x;
  pending_ = false;
  std::vector<double> before;
  if (variation_) {
    variation_->begin_event(d);
    before = x;
  }
  if (pace_length_ > 0) pace_.quicken(pace_length_ / greatest_speed(d.system, v()));
  if (last_.is_phase()) {
    d.phases.cross(d.system, {last_.index, last_.kind == ModeEvent::Kind::phase_up, method_.t});
    d.forget_place();
  }
  const double t = method_.t;
  // Closed contacts drift within a step by its error. The projection prevents that this drift
  // appears as a separation.
  d.project(x, t, forces_.impulses_before());
  d.measure_speeds(x);
  std::vector<int> was_closed;
  for (int k = 0; k < d.system.contacts(); ++k)
    if (d.contacts[k].closed) was_closed.push_back(k);
  auto touching = impacts_.touching(d, x, t, last_);
  if (last_.kind != ModeEvent::Kind::gap && last_.kind != ModeEvent::Kind::none)
    if (const auto reason = pace_.mode_change(t); !reason.empty()) return beyond(reason);
  if (const auto reason = impacts_.solve(d, x, t, last_, touching, pace_, findings_, forces_);
      !reason.empty())
    return pace_.exceeded() ? beyond(reason) : fail(reason);
  if (!choose(touching)) return false;
  d.project(x, t, forces_.impulses_before());
  record(was_closed);
  if (variation_)
    variation_->cross_event(d, {last_, t, before, x, impacts_.in_impact(), impacts_.ended(), impacts_});
  method_.start(d, t, std::vector<double>(x));
  search_.mark_gaps(d, method_, true);
  return true;
}

/// The mode that follows where a force of the present mode has reached its limit. There the
/// accelerations of the contacts that open or begin to slip vanish, and the problem in accelerations
/// has several solutions up to rounding. Their jerks ẅ and the rates of the forces decide,
///
///     0 ≤ λ̇_N ⊥ g⃛ ≥ 0 (λ_N = 0),     0 ≤ (μλ_N − |λ_T|)˙ ⊥ −sgn(λ_T) ü_T ≥ 0 (|λ_T| = μλ_N),
///
/// together with the contacts that keep their state. This is the limit δ → 0 of the problem in
/// accelerations at the state that the present mode reaches after a time δ, divided by δ: it is
/// homogeneous. It is solved there, with δ well above the rounding of the forces and below the time
/// in which they change. Returns nothing if the present mode remains consistent for all δ.
std::optional<std::string> EventDriven::choose_ahead(const std::vector<int>& touching) {
  auto& d = dynamics_;
  static constexpr int open = 2;
  const auto mode = [&d] {
    std::vector<int> list;
    for (const auto& c : d.contacts) list.push_back(c.closed ? c.slip : open);
    for (const auto& p : d.preloaded) list.push_back(p.slip);
    return list;
  };
  const auto sliding = [&] {
    std::vector<int> list;
    const auto& x = method_.x;
    const auto put = [&](int slip, double rate, double zero) {
      list.push_back(std::abs(rate) > zero ? slip : 0);
    };
    for (int k = 0; k < d.system.contacts(); ++k) {
      const auto& c = d.contacts[k];
      put(c.closed ? c.slip : 0, d.look(k, x, method_.t).tangent.dot(v()), d.slide_tolerance());
    }
    for (int k = 0; k < d.system.frictions(); ++k)
      put(d.preloaded[k].slip, d.slide_rate(k, x, method_.t), d.preloaded[k].share * d.slide_tolerance());
    return list;
  };
  const auto present = mode();
  const auto slides = sliding();
  const auto n = method_.x.size();
  std::vector<std::vector<double>> ahead;
  std::vector<double> slope(n), middle(n);
  const double shortest = 1e-5 * span_, delays[] = {1e-3 * span_, shortest, 1e-2 * span_};
  d(method_.x, slope, method_.t);
  const auto clear = search_.clear_of_limits(d, method_.x, last_);
  for (const double delay : delays) {  // midpoint rule
    for (std::size_t i = 0; i < n; ++i) middle[i] = method_.x[i] + 0.5 * delay * slope[i];
    ahead.emplace_back(n);
    d(middle, ahead.back(), method_.t + 0.5 * delay);
    for (std::size_t i = 0; i < n; ++i) ahead.back()[i] = method_.x[i] + delay * ahead.back()[i];
  }
  for (std::size_t k = 0; k < ahead.size(); ++k) {
    if (!is_finite(ahead[k])) continue;
    auto reason = d.choose(ahead[k], method_.t + delays[k], touching);
    if (d.locked_up()) continue;
    if (!reason.empty()) return reason;
    const auto next = mode();
    // Sliding that stops within δ is a later event, and so is a force that only then reaches its limit.
    bool later = false;
    for (std::size_t i = 0; i < next.size(); ++i)
      later = later || (slides[i] != 0 && next[i] != open && next[i] != slides[i]) ||
              (delays[k] > shortest && clear[i] && next[i] != present[i]);
    if (!later && next != present) return reason;
  }
  return {};
}

/// Determines the mode.
bool EventDriven::choose(std::vector<int>& touching) {
  auto& d = dynamics_;
  std::optional<std::string> decided;
  const bool of_force = last_.is_of_force() && impacts_.in_impact().empty();
  if (of_force) {
    decided = choose_ahead(touching);
    d.counts.unresolved += !decided;
  }
  const auto reason = decided ? *decided : d.choose(method_.x, method_.t, touching);
  if (!reason.empty()) return d.locked_up() && touching.size() > 1 ? end_lockup(touching) : fail(reason);
  if (of_force && !decided) slip_if_repeated();
  return true;
}

/// Near a dead centre a joint moves too little for the problem in accelerations to tell stick from slip,
/// while the force that would hold it grows beyond its limit. If it reaches the limit again and again at one
/// instant, it slips.
void EventDriven::slip_if_repeated() {
  constexpr int most = 4;
  if (last_.kind != ModeEvent::Kind::slide_stick) return;
  kept_ = method_.t - kept_at_ <= pace_.instant() ? kept_ + 1 : 1;
  kept_at_ = method_.t;
  auto& p = dynamics_.preloaded[static_cast<std::size_t>(last_.index)];
  if (kept_ < most || p.slip != 0) return;
  const double delay = 1e-3 * span_;
  auto ahead = method_.x;
  std::vector<double> slope(ahead.size());
  dynamics_(method_.x, slope, method_.t);
  for (std::size_t i = 0; i < ahead.size(); ++i) ahead[i] += delay * slope[i];
  dynamics_(ahead, slope, method_.t + delay);
  if (p.slack() < 0) p.slip = p.lambda > 0 ? -1 : 1;
}

/// If friction admits no finite forces, or none are found, sliding ends by an impact without
/// collision (Génot and Brogliato, Eur. J. Mech. A/Solids 18 (1999) 653), and the mode is
/// determined anew. A single contact stops the run instead, because such a scene studies this case.
bool EventDriven::end_lockup(std::vector<int>& touching) {
  auto& d = dynamics_;
  if (variation_) variation_->refuse(fmt::format("t = {:.9g} s: sliding locks up (Painlevé)", method_.t));
  if (hands_over_)
    return fail(d.lockup_proved() ? "Painlevé paradox: friction admits no finite force at a sliding contact"
                                  : "no solver found admissible forces at a sliding contact");
  bool proved = true;
  for (int tries = 0; tries < 3; ++tries) {
    const double kinetic = d.system.kinetic(v());
    auto& kind = d.lockup_proved() ? findings_.lockups : findings_.unsolved;
    proved = proved && d.lockup_proved();
    if (const auto reason = d.apply_impact(method_.x, method_.t, {touching, touching, true}); !reason.empty())
      return fail(reason);
    forces_.apply_impact(d, method_.x, touching);
    forces_.keep_impact();
    kind.take(kinetic - d.system.kinetic(v()));
    std::erase_if(touching, [&](int k) {
      return d.look(k, method_.x, method_.t).normal.dot(v()) > 2 * d.last_impact().pressing_rate();
    });
    const auto reason = d.choose(method_.x, method_.t, touching);
    if (reason.empty()) return true;
    if (!d.locked_up()) return fail(reason);
  }
  return fail(
      proved ? "Painlevé paradox: friction admits no acceleration, even after three impacts without collision"
             : "no solver found admissible accelerations, even after three impacts without collision; they "
               "may exist");
}

}  // namespace freeplay
