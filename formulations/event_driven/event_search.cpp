// Where a mode ends: the search on the dense output of a step, and the landing.
#include <algorithm>
#include <cmath>

#include "formulations/event_driven/event_driven.hpp"

namespace freeplay {

double EventDriven::rounding(int k) const { return gap_rounding(dynamics_.system(), k, q()); }

/// How far a gap may go below zero before it counts as closed (m).
double EventDriven::slack(int k) const {
  if (dynamics_.contacts()[k].resting) return dynamics_.closed_gap(k, q());
  return rounding(k);
}
/// A hop not higher than this (m) is over.
double EventDriven::least_hop(int k) const {
  return std::max(1e-9 * dynamics_.system().contact_facts(k).clearance, 1e3 * rounding(k));
}

Watched EventDriven::gap_at(int k, double t) {
  const auto& x = at(t);
  const auto& row = dynamics_.look(k, x, t);
  // A contact that has just opened starts within rounding of zero.
  return {row.gap + slack(k) + mark_[k].allowance, row.normal.dot(x.data() + dynamics_.system().n())};
}

/// Gaps at the end of a step. One that begins below zero opens from there: the correction of what is closed
/// moved it, or its impact was merged with another's.
void EventDriven::mark_gaps(bool begin) {
  for (int k = 0; k < dynamics_.system().contacts(); ++k) {
    auto& mark = mark_[k];
    if (begin || mark.allowance > 0) {
      const double before = begin ? INFINITY : mark.allowance;
      mark.allowance = 0;
      const double below = gap_at(k, method_.t).value;
      if (below < 0) mark.allowance = std::min(-below, before);
    }
    mark.gap = gap_at(k, method_.t);
  }
}

GapMotion EventDriven::motion_of(int k) {
  return narrowed(
      dynamics_.gap_motion(k, bounds_, method_.x), dynamics_.system(), k, method_,
      [&] { return dynamics_.look(k, method_.x, method_.t).normal; }, scratch_);
}

/// False where the last step is too long: nothing bounds how a gap bends in it, or a contact would be found only when it lies
/// a hundredth of its clearance inside its wall.
bool EventDriven::find_gap_events(Event& first) {
  const auto& system = dynamics_.system();
  if (!(method_.t > method_.t_old)) return true;
  if (system.contacts() > 0) method_.enclose(static_cast<std::size_t>(system.n()), bounds_);
  step_unseen_ = 0;
  for (int k = 0; k < dynamics_.system().contacts(); ++k) {
    if (dynamics_.contacts()[k].closed) continue;
    const auto motion = motion_of(k);
    if (!std::isfinite(motion.bend)) return false;
    const auto end = gap_at(k, method_.t);
    double unseen = 0;
    const auto t = first_loss([&](double at) { return gap_at(k, at); }, method_.t_old, method_.t,
                              mark_[k].gap, end, motion, rounding(k), unseen);
    const double clearance = system.contact_facts(k).clearance;
    if (t && mark_[k].gap.value >= -too_deep * clearance && gap_at(k, *t).value < -too_deep * clearance)
      return false;
    step_unseen_ = std::max(step_unseen_, unseen / clearance);
    if (t && (*t < first.t || first.kind == Event::Kind::none)) first = {Event::Kind::gap, k, *t};
  }
  return true;
}

/// Angles that come to a kink of their torque table.
void EventDriven::find_phase_events(Event& first) {
  if (!dynamics_.phases.any()) return;
  double unseen = 0;
  const auto& system = dynamics_.system();
  if (system.contacts() == 0) method_.enclose(static_cast<std::size_t>(system.n()), bounds_);
  const auto c = dynamics_.phases.first(system, method_.t_old, method_.t, method_.x_old, method_.x, bounds_,
                                        first.kind == Event::Kind::none ? INFINITY : first.t, unseen,
                                        [&](double t) -> const std::vector<double>& { return at(t); });
  if (c.phase >= 0) first = {c.up ? Event::Kind::phase_up : Event::Kind::phase_down, c.phase, c.t};
}

/// What must stay positive for the mode to last, from the last evaluation of the dynamics.
void EventDriven::watch(const std::vector<double>& x, std::vector<double>& values) {
  values.clear();
  watched_.clear();
  const auto put = [&](Event::Kind kind, int k, double value) {
    watched_.push_back({kind, k, 0});
    values.push_back(value);
  };
  const double* v = x.data() + dynamics_.system().n();
  for (int k = 0; k < dynamics_.system().contacts(); ++k) {
    const auto& c = dynamics_.contacts()[k];
    if (!c.closed) continue;
    const double rest = 2 * dynamics_.rest_speed();  // a speed at which what was at rest has begun to move
    const bool together = dynamics_.together();
    put(Event::Kind::force, k, together ? rest - c.row.normal.dot(v) : c.lambda_n);
    if (c.row.tangent.size == 0) continue;
    if (together && c.slip == 0) {
      put(Event::Kind::stick, k, rest - std::abs(c.row.tangent.dot(v)));
      continue;
    }
    const double bound = *dynamics_.system().contact_facts(k).surface.friction * c.lambda_n;
    if (c.slip == 0)
      put(Event::Kind::stick, k, bound - std::abs(c.lambda_t));
    else
      put(Event::Kind::slip, k, c.slip * c.row.tangent.dot(v));
  }
  for (int k = 0; k < dynamics_.system().frictions(); ++k) {
    const auto& p = dynamics_.preloaded()[k];
    if (p.slip == 0 && dynamics_.together())
      put(Event::Kind::slide_stick, k, 2 * p.share * dynamics_.rest_speed() - std::abs(p.rate));
    else if (p.slip == 0)
      put(Event::Kind::slide_stick, k, p.bound - std::abs(p.lambda));
    else
      put(Event::Kind::slide_slip, k, p.slip * p.rate);
  }
}

void EventDriven::values_at(double t, std::vector<double>& values) {
  const auto& x = at(t);
  dynamics_(x, slope_, t);
  watch(x, values);
}

/// Where what is watched, positive at a step's ends and middle, falls below zero between them, as sliding does that turns round
/// for a moment: looked for around the vertex of the parabola through the three where that comes near zero.
std::optional<EventDriven::Dip> EventDriven::find_dip(std::size_t i, double start, double middle, double end,
                                                      double shift) {
  const double bend = 2 * (start - 2 * middle + end), slope = 4 * middle - 3 * start - end;
  if (!(bend > 0 && slope < 0 && slope > -2 * bend)) return {};
  const double least = std::min({start, middle, end});
  if (!(start - 0.25 * slope * slope / bend < 0.5 * least)) return {};
  const double t0 = method_.t_old, h = method_.t - t0, vertex = -0.5 * slope / bend;
  // By thirds around the vertex, as far as the parabola may be wrong.
  double from = std::max(0.0, vertex - 0.25), to = std::min(1.0, vertex + 0.25);
  for (int tries = 0; tries < 12; ++tries) {
    const double s[2] = {from + (to - from) / 3, to - (to - from) / 3};
    double f[2];
    for (int k = 0; k < 2; ++k) {
      values_at(t0 + s[k] * h, between_);
      f[k] = between_[i] + shift;
      if (f[k] < 0) return Dip{t0 + s[k] * h, f[k]};
    }
    if (std::min(f[0], f[1]) > 0.5 * least) return {};
    if (f[0] < f[1])
      to = s[1];
    else
      from = s[0];
  }
  return {};
}

void EventDriven::find_mode_events(Event& first) {
  if (watched_.empty()) return;
  const double t0 = method_.t_old, t1 = method_.t, tm = 0.5 * (t0 + t1);
  values_at(tm, middle_);
  values_at(t1, after_);
  const auto take = [&](std::size_t i, double a, double b, double fa, double fb, double shift) {
    auto event = watched_[i];
    event.t = a;
    if (fa > 0) {
      std::vector<double> values;
      event.t = bracketed_root(
          [&](double s) {
            values_at(s, values);
            return values[i] + shift;
          },
          a, b, fa, fb);
    }
    if (event.t < first.t || first.kind == Event::Kind::none) first = event;
  };
  for (std::size_t i = 0; i < watched_.size(); ++i) {
    const bool speed = watched_[i].kind == Event::Kind::slip || watched_[i].kind == Event::Kind::slide_slip;
    // A surface that has just begun to slide, or is held still at its bound, is at rest within the tolerance.
    const double tolerance = watched_[i].kind == Event::Kind::slide_slip
                                 ? dynamics_.preloaded()[static_cast<std::size_t>(watched_[i].index)].share *
                                       dynamics_.slide_tolerance()
                                 : dynamics_.slide_tolerance();
    const bool fresh = speed && before_[i] <= tolerance;
    const double shift = fresh ? tolerance : 0;
    const double start = (fresh ? std::max(before_[i], 0.0) : before_[i]) + shift;
    if (middle_[i] + shift < 0)
      take(i, t0, tm, start, middle_[i] + shift, shift);
    else if (after_[i] + shift < 0)
      take(i, tm, t1, middle_[i] + shift, after_[i] + shift, shift);
    else if (const auto dip = find_dip(i, start, middle_[i] + shift, after_[i] + shift, shift))
      take(i, t0, dip->t, start, dip->value, shift);
  }
}

/// Steps from the old state to the event.
void EventDriven::land(Event& event) {
  ++dynamics_.work.events;
  if (event.kind == Event::Kind::phase_up || event.kind == Event::Kind::phase_down) {
    Phases::Crossing c{event.index, event.kind == Event::Kind::phase_up, event.t};
    dynamics_.phases.land(dynamics_.system(), method_, dynamics_, c);
    event.t = c.t;
  } else if (event.kind != Event::Kind::gap || dynamics_.contacts()[event.index].resting ||
             mark_[event.index].allowance > 0)
    land_at(method_, dynamics_, event.t);
  else
    land_on_gap(method_, dynamics_, event.t, rounding(event.index), [&] {
      const auto& row = dynamics_.look(event.index, method_.x, method_.t);
      return Watched{row.gap, row.normal.dot(v())};
    });
}

}  // namespace freeplay
