#include "formulations/event_driven/event_search.hpp"

#include <algorithm>

#include "formulations/integrators/curve_limit.hpp"

namespace freeplay {

namespace {

bool any_open(const EventDynamics& d) {
  return std::ranges::any_of(d.contacts, [](const ModeContact& c) { return !c.closed; });
}

}  // namespace

EventSearch::EventSearch(const EventDynamics& dynamics)
    : peaks_(dynamics.system),
      marks_(static_cast<std::size_t>(dynamics.system.contacts())),
      slope_(static_cast<std::size_t>(dynamics.size())),
      scratch_(static_cast<std::size_t>(dynamics.size())) {}

const EventSearch::Vector& EventSearch::at(const Method& m, double t) const {
  if (t >= m.t) return m.x;
  m.interpolate(t, scratch_);
  return scratch_;
}

ModeEvent EventSearch::find(EventDynamics& d, Method& m) {
  auto first = shorten_until_bounded(d, m);
  ++d.work.steps;
  d.work.rejected = m.rejected;
  find_mode_events(d, m, first);
  find_phase_events(d, m, first);
  find_limit_events(d, m, first);
  return first;
}

void EventSearch::land(EventDynamics& d, Method& m, ModeEvent& event) {
  land_on_first(
      m, event, [&](ModeEvent& at) { land_on(d, m, at); },
      [&](const ModeEvent&) {
        ModeEvent lost;
        lost.t = m.t;
        find_gap_events(d, m, lost);
        unseen_ = std::max(unseen_, step_unseen_);
        return lost;
      });
}

Watched EventSearch::gap_at(EventDynamics& d, const Method& m, int k, double t) {
  const auto& x = at(m, t);
  const auto& row = d.look(k, x, t);
  // Depth below zero at which a gap counts as closed. The gap of a contact that has just opened
  // begins within rounding of zero.
  const double slack =
      d.contacts[k].resting ? d.closed_gap(k, m.x.data()) : gap_rounding(d.system, k, m.x.data());
  return {row.gap + slack + marks_[k].allowance, row.normal.dot(x.data() + d.system.n())};
}

void EventSearch::mark_gaps(EventDynamics& d, const Method& m, bool begin) {
  for (int k = 0; k < d.system.contacts(); ++k) {
    auto& mark = marks_[k];
    if (begin || mark.allowance > 0) {
      const double before = begin ? INFINITY : mark.allowance;
      mark.allowance = 0;
      const double below = gap_at(d, m, k, m.t).value;
      if (below < 0) mark.allowance = std::min(-below, before);
    }
    mark.gap = gap_at(d, m, k, m.t);
  }
}

/// Returns the first closing of a gap in the last step. The step is repeated, shorter, if it moved
/// a curve's argument further than accepted, as with a body that accelerates, or the speed over a peak of friction, if no bound of the
/// curvature of a gap exists, or if it leaves open whether a gap closed.
ModeEvent EventSearch::shorten_until_bounded(EventDynamics& d, Method& m) {
  int halvings = 0;
  for (int tries = 0;; ++tries) {
    ModeEvent first;
    first.t = m.t;
    const double *q0 = m.x_old.data(), *v0 = q0 + d.system.n(), *q1 = m.x.data(), *v1 = q1 + d.system.n();
    double over = std::max(curve_overreach(d.system, m.t_old, q0, v0, m.t, q1, v1, Knots::located),
                           peaks_.overreach(m.t_old, q0, v0, m.t, q1, v1));
    if (!(over > 1)) {
      if ((find_gap_events(d, m, first) && (step_unseen_ <= seen_depth || halvings++ == most_halvings)) ||
          !is_finite(m.x)) {
        unseen_ = std::max(unseen_, step_unseen_);
        return first;
      }
      over = 2;
    }
    if (tries == 60) return first;
    ++m.rejected;
    m.land(d, m.t_old + (m.t - m.t_old) / over);
    m.limit_step(2 * (m.t - m.t_old));
  }
}

/// Returns false if the last step is too long: no bound of the curvature of a gap exists, or a
/// contact would only be found at a depth of a hundredth of its clearance.
bool EventSearch::find_gap_events(EventDynamics& d, Method& m, ModeEvent& first) {
  const auto& system = d.system;
  if (!(m.t > m.t_old)) return true;
  step_unseen_ = 0;
  if (!any_open(d)) return true;
  m.enclose(static_cast<std::size_t>(system.n()), bounds_);
  for (int k = 0; k < system.contacts(); ++k) {
    if (d.contacts[k].closed) continue;
    const auto motion = narrowed(
        d.gap_motion(k, bounds_, m.x), system, k, m, [&] { return d.look(k, m.x, m.t).normal; }, scratch_);
    if (!std::isfinite(motion.acceleration)) return false;
    const auto end = gap_at(d, m, k, m.t);
    double unseen = 0;
    const auto t = first_loss([&](double at) { return gap_at(d, m, k, at); }, m.t_old, m.t, marks_[k].gap,
                              end, motion, gap_rounding(d.system, k, m.x.data()), unseen);
    const double clearance = system.contact_facts(k).clearance;
    if (t && marks_[k].gap.value >= -too_deep * clearance &&
        gap_at(d, m, k, *t).value < -too_deep * clearance)
      return false;
    step_unseen_ = std::max(step_unseen_, unseen / clearance);
    if (t && (*t < first.t || first.kind == ModeEvent::Kind::none)) first = {ModeEvent::Kind::gap, k, *t};
  }
  return true;
}

/// Finds angles that reach a kink of their torque table.
void EventSearch::find_phase_events(EventDynamics& d, const Method& m, ModeEvent& first) {
  if (!d.phases.any()) return;
  double unseen = 0;
  const auto& system = d.system;
  if (!any_open(d)) m.enclose(static_cast<std::size_t>(system.n()), bounds_);
  const auto c = d.phases.first(system, m.t_old, m.t, m.x_old, m.x, bounds_,
                                first.kind == ModeEvent::Kind::none ? INFINITY : first.t, unseen,
                                [&](double t) -> const std::vector<double>& { return at(m, t); });
  if (c.phase >= 0) first = {c.up ? ModeEvent::Kind::phase_up : ModeEvent::Kind::phase_down, c.phase, c.t};
}

void EventSearch::find_limit_events(EventDynamics& d, const Method& m, ModeEvent& first) {
  const auto c =
      limits_.first(d.system, d.state_offset(), m, first.kind == ModeEvent::Kind::none ? INFINITY : first.t,
                    Limits::rounding, [&](double t) -> const Vector& { return at(m, t); });
  if (c.found())
    first = {c.border > 0 ? ModeEvent::Kind::limit_up : ModeEvent::Kind::limit_down, c.limiter, c.t};
}

/// Lists the values that must stay positive in the present mode, from the last evaluation of the
/// dynamics.
void EventSearch::watch(const EventDynamics& d, const Vector& x, Vector& values) {
  std::size_t number = 0;
  const auto put = [&](ModeEvent::Kind kind, int k, double value) {
    if (number == watched_.size()) watched_.emplace_back();
    if (number == values.size()) values.emplace_back();
    watched_[number] = {kind, k, 0};
    values[number++] = value;
  };
  const double* v = x.data() + d.system.n();
  for (int k = 0; k < d.system.contacts(); ++k) {
    const auto& c = d.contacts[k];
    if (!c.closed) continue;
    put(ModeEvent::Kind::force, k, c.lambda_n);
    if (c.row.tangent.size == 0) continue;
    if (c.slip == 0)
      put(ModeEvent::Kind::stick, k,
          d.system.contact_facts(k).surface.friction_at_rest() * c.lambda_n - std::abs(c.lambda_t));
    else
      put(ModeEvent::Kind::slip, k, c.slip * c.row.tangent.dot(v));
  }
  for (int k = 0; k < d.system.frictions(); ++k) {
    const auto& p = d.preloaded[k];
    if (p.slip == 0)
      put(ModeEvent::Kind::slide_stick, k, p.slack());
    else
      put(ModeEvent::Kind::slide_slip, k, p.slip * p.rate);
  }
  watched_.resize(number);
  values.resize(number);
}

void EventSearch::values_at(EventDynamics& d, const Method& m, double t, Vector& values) {
  const auto& x = at(m, t);
  d(x, slope_, t);
  watch(d, x, values);
}

/// Finds where a monitored value that is positive at a step's ends and middle is negative between
/// them, as when sliding reverses for a moment. It evaluates around the vertex of the parabola
/// through the three values if that is close to zero.
std::optional<EventSearch::Dip> EventSearch::find_dip(EventDynamics& d, const Method& m, std::size_t i,
                                                      double start, double middle, double end, double shift) {
  const double bend = 2 * (start - 2 * middle + end), slope = 4 * middle - 3 * start - end;
  if (!(bend > 0 && slope < 0 && slope > -2 * bend)) return {};
  const double least = std::min({start, middle, end});
  if (!(start - 0.25 * slope * slope / bend < 0.5 * least)) return {};
  const double t0 = m.t_old, h = m.t - t0, vertex = -0.5 * slope / bend;
  // By thirds around the vertex, within the possible error of the parabola.
  double from = std::max(0.0, vertex - 0.25), to = std::min(1.0, vertex + 0.25);
  for (int tries = 0; tries < 12; ++tries) {
    const double s[2] = {from + (to - from) / 3, to - (to - from) / 3};
    double f[2];
    for (int k = 0; k < 2; ++k) {
      values_at(d, m, t0 + s[k] * h, between_);
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

/// A value that begins below this tolerance is zero to rounding, and must fall as far below zero for
/// an event: the speed of a surface that has just begun to slide, or a force that remains at its
/// limit.
double EventSearch::tolerance_of(const EventDynamics& d, const ModeEvent& event) {
  const auto k = static_cast<std::size_t>(event.index);
  constexpr double of_force = 1e-8;
  switch (event.kind) {
    case ModeEvent::Kind::slip:
      return d.slide_tolerance();
    case ModeEvent::Kind::slide_slip:
      return d.preloaded[k].share * d.slide_tolerance();
    case ModeEvent::Kind::slide_stick:
      return of_force * std::max(d.preloaded[k].bound, d.preloaded[k].opposite);
    case ModeEvent::Kind::stick:
      // without friction, µ = 0, the limit is always reached
      return std::max({of_force * std::abs(d.contacts[k].lambda_t), of_force * 1e-3 * d.contacts[k].lambda_n,
                       d.system.contact_facts(event.index).surface.friction_at_rest() *
                           d.force_tolerance(d.contacts[k].mobility)});
    default:
      return d.force_tolerance(d.contacts[k].mobility);
  }
}

/// Whether the force of each contact and joint is clear of its limits in the present mode: such a
/// force reaches them later, or not at all. That of the event is not, however far the projection moved it.
std::vector<bool> EventSearch::clear_of_limits(EventDynamics& d, const Vector& x, const ModeEvent& of) {
  constexpr double clear = 100;
  const auto contacts = d.contacts.size();
  std::vector<bool> list(contacts + d.preloaded.size());
  for (std::size_t k = 0; k < list.size(); ++k)
    list[k] = k < contacts ? d.contacts[k].closed : d.preloaded[k - contacts].slip == 0;
  const auto not_clear = [&](const ModeEvent& event) {
    list[static_cast<std::size_t>(event.index) +
         (event.kind == ModeEvent::Kind::slide_stick ? contacts : 0)] = false;
  };
  watch(d, x, middle_);
  for (std::size_t i = 0; i < watched_.size(); ++i)
    if (watched_[i].is_of_force() && !(middle_[i] > clear * tolerance_of(d, watched_[i])))
      not_clear(watched_[i]);
  not_clear(of);
  return list;
}

void EventSearch::find_mode_events(EventDynamics& d, const Method& m, ModeEvent& first) {
  if (watched_.empty()) return;
  const double t0 = m.t_old, t1 = m.t, tm = 0.5 * (t0 + t1);
  values_at(d, m, tm, middle_);
  values_at(d, m, t1, after_);
  const auto take = [&](std::size_t i, double a, double b, double fa, double fb, double shift) {
    auto event = watched_[i];
    event.t = a;
    if (fa > 0) {
      Vector values;
      event.t = bracketed_root(
          [&](double s) {
            values_at(d, m, s, values);
            return values[i] + shift;
          },
          a, b, fa, fb);
    }
    if (event.t < first.t || first.kind == ModeEvent::Kind::none) first = event;
  };
  for (std::size_t i = 0; i < watched_.size(); ++i) {
    const double tolerance = tolerance_of(d, watched_[i]);
    const bool fresh = before_[i] <= tolerance;
    const double shift = fresh ? tolerance : 0;
    const double start = (fresh ? std::max(before_[i], 0.0) : before_[i]) + shift;
    if (middle_[i] + shift < 0)
      take(i, t0, tm, start, middle_[i] + shift, shift);
    else if (after_[i] + shift < 0)
      take(i, tm, t1, middle_[i] + shift, after_[i] + shift, shift);
    else if (const auto dip = find_dip(d, m, i, start, middle_[i] + shift, after_[i] + shift, shift))
      take(i, t0, dip->t, start, dip->value, shift);
  }
}

/// Repeats the step to end at the event.
void EventSearch::land_on(EventDynamics& d, Method& m, ModeEvent& event) {
  ++d.work.events;
  if (event.is_phase()) {
    Phases::Crossing c{event.index, event.kind == ModeEvent::Kind::phase_up, event.t};
    d.phases.land(d.system, m, d, c);
    event.t = c.t;
  } else if (event.is_limit()) {
    Limits::Crossing c{event.index, event.kind == ModeEvent::Kind::limit_up ? 1.0 : -1.0, event.t};
    limits_.land(d.system, d.state_offset(), m, d, c);
    event.t = c.t;
  } else if (event.kind != ModeEvent::Kind::gap || d.contacts[event.index].resting ||
             marks_[event.index].allowance > 0)
    land_at(m, d, event.t);
  else
    land_on_gap(m, d, event.t, gap_rounding(d.system, event.index, m.x.data()), [&] {
      const auto& row = d.look(event.index, m.x, m.t);
      return Watched{row.gap, row.normal.dot(m.x.data() + d.system.n())};
    });
}

}  // namespace freeplay
