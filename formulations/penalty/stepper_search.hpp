// Contact events within a step of the penalty formulation: where gaps change sign, where sliding
// speeds leave their zones, and where impacts on closed contacts begin or end.
#pragma once

#include "formulations/penalty/stepper.hpp"

namespace freeplay {

template <class Method>
bool PenaltyStepper<Method>::step_within_curves(double t_end) {
  const double limit = curve_step_limit(f_.system(), method_.t, q(), v(), Knots::located);
  if constexpr (!Method::fixed_step) t_end = std::min(t_end, method_.t + limit);
  for (;;) {
    if (!method_.step(f_, t_end)) return false;
    const double h = method_.t - method_.t_old;
    const double beyond = curve_overreach(f_.system(), method_.t_old, method_.x_old.data(), v_old(),
                                          method_.t, q(), v(), Knots::located);
    if constexpr (Method::fixed_step) {
      coarse_ = std::max({coarse_, h / limit, beyond});
      return true;
    }
    if (!(beyond > 1)) return true;
    t_end = method_.t_old + h / beyond;
    if (!(t_end > method_.t_old)) return true;  // time resolves no shorter step
    ++method_.rejected;
    scratch_ = method_.x_old;
    method_.start(f_, method_.t_old, scratch_);
  }
}

template <class Method>
bool PenaltyStepper<Method>::enclose() {
  if (!(method_.t > method_.t_old)) return false;
  if (f_.system().contacts() > 0 || f_.phases.any())
    method_.enclose(static_cast<std::size_t>(f_.system().n()), bounds_);
  return true;
}

template <class Method>
void PenaltyStepper<Method>::find_gap_event(int k, Event& first) {
  const bool closed = f_.contacts()[k].closed;
  auto motion = f_.gap_motion(k, bounds_, method_.x);
  if (unloaded_[k])
    motion = narrowed(
        motion, f_.system(), k, method_, [&] { return f_.end_row(k, method_.x).normal; }, scratch_);
  double unseen = 0;
  const auto t = first_loss([&](double at) { return watched(k, sample_at(k, at)); }, method_.t_old, method_.t,
                            watched(k, mark_[k].at), watched(k, end_[k]), closed ? motion.opposite() : motion,
                            gap_rounding(f_.system(), k, q()), unseen);
  unseen_ = std::max(unseen_, unseen / f_.system().contact_facts(k).clearance);
  if (t && (*t < first.t || !first.found())) first = {k, Event::Kind::gap, *t, 0};
}

template <class Method>
void PenaltyStepper<Method>::find_unloaded() {
  const auto& system = f_.system();
  const auto n = static_cast<std::size_t>(system.n());
  double greatest = -1;  // m/s², of all coordinates except angles
  for (int k = 0; k < system.contacts(); ++k) {
    const auto& at = mark_[k].at;
    auto& unloaded = unloaded_[static_cast<std::size_t>(k)];
    unloaded = false;
    if (f_.contacts()[k].closed || !(std::abs(at.gap) <= unloaded_gap(k))) continue;
    double speed = 0;
    for (const int body : system.contact_facts(k).bodies)
      if (body != ground) speed = std::max(speed, planar::velocity(v(), body).norm());
    if (!(std::abs(at.rate) <= 1e-6 * v0_floor_ + 1e-14 * speed)) continue;
    if (greatest < 0)
      for (std::size_t i = 0; i < n; ++i)
        if (!system.is_angle(static_cast<int>(i)))
          greatest = std::max(greatest, std::abs(method_.dxdt[n + i]));
    // If nothing else acts, forces at penetrations of rounding are the greatest forces; they are no
    // load either.
    const double acceleration = std::abs(gap_acceleration(k, method_.x, method_.dxdt, method_.t));
    unloaded = acceleration <= 1e-9 * greatest ||
               acceleration * f_.effective_mass(f_.contact_row(k, method_.x, method_.t)) <=
                   f_.contacts()[k].law.elastic.force(64 * gap_rounding(system, k, q()));
  }
}

template <class Method>
void PenaltyStepper<Method>::find_phase_event(Event& first) {
  if (!f_.phases.any()) return;
  double unseen = 0;  // a line through a kink: its rate is conclusive
  const auto crossing =
      f_.phases.first(f_.system(), method_.t_old, method_.t, method_.x_old, method_.x, bounds_,
                      first.found() ? first.t : INFINITY, unseen, [&](double t) -> const Vector& {
                        if (t >= method_.t) return method_.x;
                        method_.interpolate(t, scratch_);
                        return scratch_;
                      });
  if (crossing.phase >= 0) first = {-1, Event::Kind::gap, crossing.t, 0, crossing};
}

template <class Method>
void PenaltyStepper<Method>::find_limit_event(Event& first) {
  const auto crossing =
      limits_.first(f_.system(), f_.state_offset(), method_, first.found() ? first.t : INFINITY,
                    Limits::rounding, [&](double t) -> const Vector& {
                      if (t >= method_.t) return method_.x;
                      method_.interpolate(t, scratch_);
                      return scratch_;
                    });
  if (crossing.found()) {
    first = {};
    first.t = crossing.t;
    first.limit = crossing;
  }
}

template <class Method>
void PenaltyStepper<Method>::find_slide_event(int k, Event& first) {
  const auto& c = f_.contacts()[k];
  if (!c.closed || !c.rubs()) return;
  if (c.shear && c.zone != 0) return find_slip_end(k, first);
  if (c.shear) {
    for (const int side : {-1, 1})
      find_zone_end(k, first, side,
                    [&](double t) { return 1 + c.zone_tolerance() - side * sample_at(k, t).slide; });
    return;
  }
  const auto [low, high] = c.zone_ends();
  const double before = mark_[k].at.slide, after = end_[k].slide;
  if (after >= low && after <= high) return;
  const double boundary = after > high ? high : low;
  // already beyond it: at once, or follow_zone()
  if ((before - boundary) * (after - boundary) >= 0) {
    if (std::abs(before - boundary) <= c.zone_tolerance() && first.t > method_.t_old)
      first = {k, Event::Kind::slide, method_.t_old, boundary};
    return;
  }
  const double t = bracketed_root([&](double s) { return sample_at(k, s).slide - boundary; }, method_.t_old,
                                  method_.t, before - boundary, after - boundary);
  if (t < first.t || !first.found()) first = {k, Event::Kind::slide, t, boundary};
}

template <class Method>
double PenaltyStepper<Method>::slip(int k, const Vector& x, const Vector& slope, double t) {
  const auto& c = f_.contacts()[k];
  const double acceleration = -gap_acceleration(k, x, slope, t);
  const auto& row = f_.contact_row(k, x, t);
  const double* v = x.data() + f_.system().n();
  const double rate = -row.normal.dot(v), delta = std::max(0.0, -row.gap);
  // g and its derivative along the motion
  const auto moving = [](double x, double x_rate) {
    Dual<1> dual(x);
    dual.slope[0] = x_rate;
    return dual;
  };
  const auto g = c.force(moving(delta, rate), moving(rate, acceleration), Dual<1>(1));
  return c.zone * c.shear->slip(c.zone, delta, rate, g.value, g.slope[0], row.tangent.dot(v));
}

template <class Method>
void PenaltyStepper<Method>::find_slip_end(int k, Event& first) {
  const auto value = [&](double at) {
    if (at >= method_.t) return slip(k, method_.x, method_.dxdt, method_.t);
    if (at <= method_.t_old) return slip(k, method_.x_old, method_.dxdt_old, method_.t_old);
    method_.interpolate(at, moving_);
    f_(moving_, slope_, at);
    return slip(k, moving_, slope_, at);
  };
  find_zone_end(k, first, 0, value);
}

template <class Method>
template <class F>
void PenaltyStepper<Method>::find_zone_end(int k, Event& first, double boundary, F value) {
  // In a step as long as the contact, the value may leave its zone and return.
  const int parts = Method::long_steps && !method_.relieved() ? 8 : 1;
  const double h = (method_.t - method_.t_old) / parts;
  double from = method_.t_old, before = NAN;
  for (int i = 1; i <= parts; ++i) {
    const double to = i < parts ? method_.t_old + i * h : method_.t, after = value(to);
    if (after < 0) {
      if (std::isnan(before)) before = value(from);
      const double t = before > 0 ? bracketed_root(value, from, to, before, after) : from;
      if (t < first.t || !first.found()) first = {k, Event::Kind::slide, t, boundary};
      return;
    }
    from = to;
    before = after;
  }
}

template <class Method>
double PenaltyStepper<Method>::root_of_rate(int k, double rate) {
  return bracketed_root([&](double t) { return sample_at(k, t).rate; }, method_.t_old, method_.t, rate,
                        end_[k].rate);
}

template <class Method>
double PenaltyStepper<Method>::push(int k, const Vector& x, const Vector& slope, double t) {
  const double acceleration = -gap_acceleration(k, x, slope, t), gap = f_.contact_row(k, x, t).gap;
  const auto& c = f_.contacts()[k];
  return acceleration + c.law.elastic.force(std::max(0.0, -gap)) / c.mass;
}

template <class Method>
double PenaltyStepper<Method>::gap_acceleration(int k, const Vector& x, const Vector& slope, double t) {
  const auto& row = f_.contact_row(k, x, t);
  return row.normal.dot(slope.data() + f_.system().n()) - row.gamma_n;
}

template <class Method>
double PenaltyStepper<Method>::least_gap(int k, const Sample& before) {
  if (Method::long_steps && !method_.relieved()) return sample_at(k, root_of_rate(k, before.rate)).gap;
  const double h = method_.t - method_.t_old;
  const double a0 = gap_acceleration(k, method_.x_old, method_.dxdt_old, method_.t_old),
               a1 = gap_acceleration(k, method_.x, method_.dxdt, method_.t);
  const double c0 = before.gap, c1 = h * before.rate, c2 = 0.5 * h * h * a0;
  const double d = end_[k].gap - c0 - c1 - c2, e = h * end_[k].rate - c1 - 2 * c2, f = h * h * a1 - 2 * c2;
  const double c3 = 10 * d - 4 * e + 0.5 * f, c4 = -15 * d + 7 * e - f, c5 = 6 * d - 3 * e + 0.5 * f;
  const double s =
      bracketed_root([&](double x) { return c1 + x * (2 * c2 + x * (3 * c3 + x * (4 * c4 + x * 5 * c5))); },
                     0, 1, c1, h * end_[k].rate);
  return c0 + s * (c1 + s * (c2 + s * (c3 + s * (c4 + s * c5))));
}

template <class Method>
void PenaltyStepper<Method>::find_impact_event(int k, Event& first) {
  const auto& c = f_.contacts()[k];
  if (!c.closed || !(c.law.chi > 0 || c.law.own()) || !(method_.t > method_.t_old)) return;
  // In a step as long as the contact, an impact on it may begin and end.
  const int parts = Method::long_steps && !method_.relieved() ? 8 : 1;
  const double h = (method_.t - method_.t_old) / parts;
  Instant from{method_.t_old, mark_[k].at};
  for (int i = 1; i <= parts; ++i) {
    Instant to{method_.t, end_[k]};
    if (i < parts) {
      to.t = method_.t_old + i * h;
      to.at = sample_at(k, to.t);
    }
    if (const auto t = impact_between(k, from, to)) {
      if (*t < first.t || !first.found()) first = {k, Event::Kind::impact, *t, 0};
      return;
    }
    from = to;
  }
}

template <class Method>
void PenaltyStepper<Method>::find_clamp_event(int k, Event& first) {
  if constexpr (!Method::fixed_step) return;  // the error control of others resolves the kink
  constexpr double rounding = 1e-9;           // of the force's terms: the step begins at the kink
  const auto& c = f_.contacts()[k];
  if (!c.closed || c.law.own() || !c.law.dissipates() || !(method_.t > method_.t_old)) return;
  const auto part = [&](const Sample& s) { return c.law.elastic.force(std::max(0.0, -s.gap)); };
  const auto force = [&](const Sample& s) {
    return c.law.unclamped(part(s), -s.rate, c.in_impact ? touch_speed(c, s) : c.v0);
  };
  const double before = force(mark_[k].at), after = force(end_[k]);
  if (!(before * after < 0) ||
      std::abs(before) <= rounding * (part(mark_[k].at) + c.law.viscous * std::abs(mark_[k].at.rate)))
    return;
  const double t = bracketed_root([&](double at) { return force(sample_at(k, at)); }, method_.t_old,
                                  method_.t, before, after);
  if (t < first.t || !first.found()) first = {k, Event::Kind::clamp, t, 0};
}

template <class Method>
std::optional<double> PenaltyStepper<Method>::impact_between(int k, const Instant& before,
                                                             const Instant& after) {
  constexpr double same = 0.01;
  const auto& c = f_.contacts()[k];
  const auto turn = [&] {
    return bracketed_root([&](double t) { return sample_at(k, t).rate; }, before.t, after.t, before.at.rate,
                          after.at.rate);
  };
  if (c.in_impact) {
    if (after.at.rate > 0) return before.at.rate < 0 ? turn() : before.t;
    const auto pushed = [&](double t) {
      if (t >= method_.t) return push(k, method_.x, method_.dxdt, t);
      if (t <= method_.t_old) return push(k, method_.x_old, method_.dxdt_old, t);
      method_.interpolate(t, moving_);
      f_(moving_, slope_, t);
      return push(k, moving_, slope_, t);
    };
    const double last = pushed(after.t);
    if (last >= 0) return {};
    const double earlier = pushed(before.t);
    if (earlier <= 0) return before.t;
    return bracketed_root(pushed, before.t, after.t, earlier, last);
  }
  if (!(after.at.rate < 0)) return {};
  Instant begin = before;
  if (before.at.rate > 0) {  // compressed again
    begin.t = turn();
    begin.at = sample_at(k, begin.t);
    const double w = touch_speed(c, begin.at);
    if (std::abs(w - c.v0) > same * c.v0 && std::max(w, c.v0) > v0_floor_) return begin.t;
  }
  // The first compression keeps the speed of its onset, whatever the load in the meantime.
  const double now = touch_speed(c, after.at);
  if (!c.eased || !(now > (1 + same) * c.v0)) return {};
  const double w = touch_speed(c, begin.at);
  if (w >= c.v0) return begin.t;
  return bracketed_root([&](double t) { return touch_speed(c, sample_at(k, t)) - c.v0; }, begin.t, after.t,
                        w - c.v0, now - c.v0);
}

template <class Method>
bool PenaltyStepper<Method>::leaps() const {
  // If Baumgarte's terms are too fast for the step, they cause the divergence.
  if (method_.relieved() || f_.pull() * (method_.t - method_.t_old) > 1) return false;
  for (int k = 0; k < f_.system().contacts(); ++k) {
    const auto& c = f_.contacts()[k];
    if (!c.closed || !c.friction) continue;
    const auto [low, high] = c.zone_ends();
    if (std::isfinite(high - low) && std::abs(end_[k].slide - mark_[k].at.slide) > 100 * (high - low))
      return true;
  }
  return false;
}

}  // namespace freeplay
