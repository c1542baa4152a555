// PenaltySearch: contact events within a step of the penalty formulation: where gaps change sign, where
// sliding speeds leave their zones, and where impacts on closed contacts begin or end. So are kinks of
// tables and limits of controllers found.
//
// It owns bounds of the last step's motion, and the greatest possible depth of an undetected contact.
#pragma once

#include <cmath>
#include <optional>

#include "formulations/integrators/curve_limit.hpp"
#include "formulations/penalty/penalty_motion.hpp"

namespace freeplay {

template <class Method>
class PenaltySearch {
 public:
  using Motion = PenaltyMotion<Method>;

  /// Sets unloaded contacts for the next step.
  static void find_unloaded(Motion& m) {
    const auto& system = m.f.system();
    const auto n = static_cast<std::size_t>(system.n());
    double greatest = -1;  // m/s², of all coordinates except angles
    for (int k = 0; k < system.contacts(); ++k) {
      const auto& at = m.mark[k].at;
      auto& unloaded = m.unloaded[static_cast<std::size_t>(k)];
      unloaded = false;
      if (m.f.contacts()[k].closed || !(std::abs(at.gap) <= m.unloaded_gap(k))) continue;
      double speed = 0;
      for (const int body : system.contact_facts(k).bodies)
        if (body != ground) speed = std::max(speed, planar::velocity(m.v(), body).norm());
      if (!(std::abs(at.rate) <= 1e-6 * m.v0_floor + 1e-14 * speed)) continue;
      if (greatest < 0)
        for (std::size_t i = 0; i < n; ++i)
          if (!system.is_angle(static_cast<int>(i)))
            greatest = std::max(greatest, std::abs(m.method.dxdt[n + i]));
      // If nothing else acts, forces at penetrations of rounding are the greatest forces; they are no
      // load either.
      const double acceleration = std::abs(gap_acceleration(m, k, m.method.x, m.method.dxdt, m.method.t));
      unloaded = acceleration <= 1e-9 * greatest ||
                 acceleration * m.f.effective_mass(m.f.contact_rows.at(k, m.method.x, m.method.t)) <=
                     m.f.contacts()[k].law.elastic.force(64 * gap_rounding(system, k, m.q()));
    }
  }
  /// Finds the first contact event of the last step, and fills m.end. False if the state is not finite.
  bool find_contact_event(Motion& m, PenaltyEvent& first) {
    enclose(m);
    m.f.place_end(m.method.x, m.method.t);
    for (int k = 0; k < m.f.system().contacts(); ++k) {
      m.end[k] = m.sample_end(k);
      if (!std::isfinite(m.end[k].gap + m.end[k].rate + m.end[k].slide)) return false;
      find_gap_event(m, k, first);
      find_slide_event(m, k, first);
      find_impact_event(m, k, first);
      find_clamp_event(m, k, first);
    }
    return true;
  }
  /// A kink of a table or a limit of a controller before `first`.
  void find_kink(Motion& m, PenaltyEvent& first) {
    find_phase_event(m, first);
    find_limit_event(m, first);
  }
  /// Repeats the step to end at the first event.
  void land_on_first(Motion& m, PenaltyEvent& first) {
    freeplay::land_on_first(
        m.method, first, [&](PenaltyEvent& event) { land(m, event); },
        [&](const PenaltyEvent& landed) {
          PenaltyEvent lost;
          lost.t = m.method.t;
          if (!enclose(m)) return lost;
          m.f.place_end(m.method.x, m.method.t);
          for (int k = 0; k < m.f.system().contacts(); ++k) {
            m.end[k] = m.sample_end(k);
            if (k != landed.contact) find_gap_event(m, k, lost);
          }
          return lost;
        });
  }
  /// Least gap of contact k in the last step, in which its rate changed sign; `before` is its
  /// beginning. By the quintic through gaps, rates and accelerations at the ends, or by the
  /// method's own interpolant.
  static double least_gap(Motion& m, int k, const ContactSample& before) {
    if (Method::long_steps && !m.method.relieved()) {
      const double turn = bracketed_root([&](double t) { return m.sample_at(k, t).rate; }, m.method.t_old,
                                         m.method.t, before.rate, m.end[k].rate);
      return m.sample_at(k, turn).gap;
    }
    const double h = m.method.t - m.method.t_old;
    const double a0 = gap_acceleration(m, k, m.method.x_old, m.method.dxdt_old, m.method.t_old),
                 a1 = gap_acceleration(m, k, m.method.x, m.method.dxdt, m.method.t);
    const double c0 = before.gap, c1 = h * before.rate, c2 = 0.5 * h * h * a0;
    const double d = m.end[k].gap - c0 - c1 - c2, e = h * m.end[k].rate - c1 - 2 * c2,
                 f = h * h * a1 - 2 * c2;
    const double c3 = 10 * d - 4 * e + 0.5 * f, c4 = -15 * d + 7 * e - f, c5 = 6 * d - 3 * e + 0.5 * f;
    const double s =
        bracketed_root([&](double x) { return c1 + x * (2 * c2 + x * (3 * c3 + x * (4 * c4 + x * 5 * c5))); },
                       0, 1, c1, h * m.end[k].rate);
    return c0 + s * (c1 + s * (c2 + s * (c3 + s * (c4 + s * c5))));
  }
  /// Whether a fixed step has changed a sliding speed that began in a steep zone of its friction
  /// law far beyond that zone. No motion does this: the step is unstable there.
  static bool slip_diverges(const Motion& m) {
    // If Baumgarte's terms are too fast for the step, they cause the divergence.
    if (m.method.relieved() || m.f.pull() * (m.method.t - m.method.t_old) > 1) return false;
    for (int k = 0; k < m.f.system().contacts(); ++k) {
      const auto& c = m.f.contacts()[k];
      if (!c.closed || !c.friction) continue;
      const auto [low, high] = c.zone_ends();
      if (std::isfinite(high - low) && std::abs(m.end[k].slide - m.mark[k].at.slide) > 100 * (high - low))
        return true;
    }
    return false;
  }
  /// Greatest possible depth of an undetected contact between the evaluated times, over its
  /// clearance; 0: excluded.
  double unseen() const { return unseen_; }

  template <class M>
  void serialize(M& m) {
    m(unseen_);
  }

 private:
  struct Instant {
    double t = 0;
    ContactSample at = {};
  };
  /// Repeats the step to end at the event.
  void land(Motion& m, PenaltyEvent& event) {
    ++m.f.work.events;
    if (event.limit.found())
      limits_.land(m.f.system(), m.f.state_offset(), m.method, m.f, event.limit);
    else if (event.contact < 0)
      m.f.phases.land(m.f.system(), m.method, m.f, event.crossing);
    else if (event.kind != PenaltyEvent::Kind::gap)
      land_at(m.method, m.f, event.t);
    else
      land_on_gap(m.method, m.f, event.t, gap_rounding(m.f.system(), event.contact, m.q()), [&] {
        const auto here = m.watched(event.contact, m.sample(event.contact, m.method.x, event.t));
        return m.f.contacts()[event.contact].closed ? Watched{-here.value, -here.rate} : here;
      });
  }
  /// Bounds the last step's motion; returns false if it has no length.
  bool enclose(Motion& m) {
    if (!(m.method.t > m.method.t_old)) return false;
    if (m.f.system().contacts() > 0 || m.f.phases.any())
      m.method.enclose(static_cast<std::size_t>(m.f.system().n()), bounds_);
    return true;
  }
  /// Finds the first change of sign of contact k's gap in the last step before first.t. Called
  /// directly after m.end[k] is set.
  void find_gap_event(Motion& m, int k, PenaltyEvent& first) {
    const bool closed = m.f.contacts()[k].closed;
    auto motion = m.f.contact_rows.gap_motion(k, bounds_, m.method.x);
    if (m.unloaded[k])
      motion = narrowed(
          motion, m.f.system(), k, m.method, [&] { return m.f.contact_rows.end(k, m.method.x).normal; },
          m.scratch);
    double unseen = 0;
    const auto t =
        first_loss([&](double at) { return m.watched(k, m.sample_at(k, at)); }, m.method.t_old, m.method.t,
                   m.watched(k, m.mark[k].at), m.watched(k, m.end[k]), closed ? motion.opposite() : motion,
                   gap_rounding(m.f.system(), k, m.q()), unseen);
    unseen_ = std::max(unseen_, unseen / m.f.system().contact_facts(k).clearance);
    if (t && (*t < first.t || !first.found())) first = {k, PenaltyEvent::Kind::gap, *t, 0};
  }
  void find_phase_event(Motion& m, PenaltyEvent& first) {
    if (!m.f.phases.any()) return;
    double unseen = 0;  // a line through a kink: its rate is conclusive
    const auto crossing = m.f.phases.first(m.f.system(), m.method.t_old, m.method.t, m.method.x_old,
                                           m.method.x, bounds_, first.found() ? first.t : INFINITY, unseen,
                                           [&](double t) -> const Vector& { return m.state_at(t); });
    if (crossing.phase >= 0) first = {-1, PenaltyEvent::Kind::gap, crossing.t, 0, crossing};
  }
  void find_limit_event(Motion& m, PenaltyEvent& first) {
    const auto crossing =
        limits_.first(m.f.system(), m.f.state_offset(), m.method, first.found() ? first.t : INFINITY,
                      Limits::rounding, [&](double t) -> const Vector& { return m.state_at(t); });
    if (crossing.found()) {
      first = {};
      first.t = crossing.t;
      first.limit = crossing;
    }
  }
  /// Finds where the sliding speed of a closed contact leaves its zone within the step.
  static void find_slide_event(Motion& m, int k, PenaltyEvent& first) {
    const auto& c = m.f.contacts()[k];
    if (!c.closed || !c.rubs()) return;
    if (c.shear && c.zone != 0) return find_slip_end(m, k, first);
    if (c.shear) {
      for (const int side : {-1, 1})
        find_zone_end(m, k, first, side,
                      [&](double t) { return 1 + c.zone_tolerance() - side * m.sample_at(k, t).slide; });
      return;
    }
    const auto [low, high] = c.zone_ends();
    const double before = m.mark[k].at.slide, after = m.end[k].slide;
    if (after >= low && after <= high) return;
    const double boundary = after > high ? high : low;
    // already beyond it: at once, or follow_zone()
    if ((before - boundary) * (after - boundary) >= 0) {
      if (std::abs(before - boundary) <= c.zone_tolerance() && first.t > m.method.t_old)
        first = {k, PenaltyEvent::Kind::slide, m.method.t_old, boundary};
      return;
    }
    const double t = bracketed_root([&](double s) { return m.sample_at(k, s).slide - boundary; },
                                    m.method.t_old, m.method.t, before - boundary, after - boundary);
    if (t < first.t || !first.found()) first = {k, PenaltyEvent::Kind::slide, t, boundary};
  }
  /// Finds where a tangential spring that slips begins to stick within the step.
  static void find_slip_end(Motion& m, int k, PenaltyEvent& first) {
    const auto value = [&](double at) {
      return moving(m, at, [&](const Vector& x, const Vector& slope) { return slip(m, k, x, slope, at); });
    };
    find_zone_end(m, k, first, 0, value);
  }
  /// The event of contact k where `value`, positive within its friction's zone, falls below zero.
  template <class F>
  static void find_zone_end(Motion& m, int k, PenaltyEvent& first, double boundary, F value) {
    // In a step as long as the contact, the value may leave its zone and return.
    const int parts = Method::long_steps && !m.method.relieved() ? 8 : 1;
    const double h = (m.method.t - m.method.t_old) / parts;
    double from = m.method.t_old, before = NAN;
    for (int i = 1; i <= parts; ++i) {
      const double to = i < parts ? m.method.t_old + i * h : m.method.t, after = value(to);
      if (after < 0) {
        if (std::isnan(before)) before = value(from);
        const double t = before > 0 ? bracketed_root(value, from, to, before, after) : from;
        if (t < first.t || !first.found()) first = {k, PenaltyEvent::Kind::slide, t, boundary};
        return;
      }
      from = to;
      before = after;
    }
  }
  /// Finds the beginning or end of an impact on a closed contact. It begins if the contact has a
  /// greater w than its v₀, or is compressed again. It ends if the load no longer exceeds the
  /// damping, or the contact expands. An impact that differs by less than a hundredth is the same.
  static void find_impact_event(Motion& m, int k, PenaltyEvent& first) {
    const auto& c = m.f.contacts()[k];
    if (!c.closed || !(c.law.hysteretic() || c.law.own()) || !(m.method.t > m.method.t_old)) return;
    // In a step as long as the contact, an impact on it may begin and end.
    const int parts = Method::long_steps && !m.method.relieved() ? 8 : 1;
    const double h = (m.method.t - m.method.t_old) / parts;
    Instant from{m.method.t_old, m.mark[k].at};
    for (int i = 1; i <= parts; ++i) {
      Instant to{m.method.t, m.end[k]};
      if (i < parts) {
        to.t = m.method.t_old + i * h;
        to.at = m.sample_at(k, to.t);
      }
      if (const auto t = impact_between(m, k, from, to)) {
        if (*t < first.t || !first.found()) first = {k, PenaltyEvent::Kind::impact, *t, 0};
        return;
      }
      from = to;
    }
  }
  /// The first such time between two times of the last step.
  static std::optional<double> impact_between(Motion& m, int k, const Instant& before, const Instant& after) {
    constexpr double same = 0.01;
    const auto& c = m.f.contacts()[k];
    const auto turn = [&] {
      return bracketed_root([&](double t) { return m.sample_at(k, t).rate; }, before.t, after.t,
                            before.at.rate, after.at.rate);
    };
    if (c.in_impact) {
      if (after.at.rate > 0) return before.at.rate < 0 ? turn() : before.t;
      const auto pushed = [&](double t) {
        return moving(m, t, [&](const Vector& x, const Vector& slope) { return push(m, k, x, slope, t); });
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
      begin.at = m.sample_at(k, begin.t);
      const double w = m.touch_speed(c, begin.at);
      if (std::abs(w - c.v0) > same * c.v0 && std::max(w, c.v0) > m.v0_floor) return begin.t;
    }
    // The first compression keeps the speed of its onset, whatever the load in the meantime.
    const double now = m.touch_speed(c, after.at);
    if (!c.eased || !(now > (1 + same) * c.v0)) return {};
    const double w = m.touch_speed(c, begin.at);
    if (w >= c.v0) return begin.t;
    return bracketed_root([&](double t) { return m.touch_speed(c, m.sample_at(k, t)) - c.v0; }, begin.t,
                          after.t, w - c.v0, now - c.v0);
  }
  /// Fixed steps: finds where the force of a closed contact reaches zero, where it is clamped, or leaves zero
  /// again. Its kink there would limit their order.
  static void find_clamp_event(Motion& m, int k, PenaltyEvent& first) {
    if constexpr (!Method::fixed_step) return;  // the error control of others resolves the kink
    constexpr double rounding = 1e-9;           // of the force's terms: the step begins at the kink
    const auto& c = m.f.contacts()[k];
    if (!c.closed || c.law.own() || !c.law.dissipates() || !(m.method.t > m.method.t_old)) return;
    const auto part = [&](const ContactSample& s) { return c.law.elastic.force(std::max(0.0, -s.gap)); };
    const auto force = [&](const ContactSample& s) {
      return c.law.unclamped(part(s), -s.rate, c.in_impact ? m.touch_speed(c, s) : c.v0);
    };
    const double before = force(m.mark[k].at), after = force(m.end[k]);
    if (!(before * after < 0) ||
        std::abs(before) <= rounding * (part(m.mark[k].at) + c.law.viscous * std::abs(m.mark[k].at.rate)))
      return;
    const double t = bracketed_root([&](double at) { return force(m.sample_at(k, at)); }, m.method.t_old,
                                    m.method.t, before, after);
    if (t < first.t || !first.found()) first = {k, PenaltyEvent::Kind::clamp, t, 0};
  }
  /// A value of the state and dx/dt at a time of the last step.
  template <class F>
  static double moving(Motion& m, double t, F value) {
    if (t >= m.method.t) return value(m.method.x, m.method.dxdt);
    if (t <= m.method.t_old) return value(m.method.x_old, m.method.dxdt_old);
    m.method.interpolate(t, m.moving);
    m.f(m.moving, m.slope, t);
    return value(m.moving, m.slope);
  }
  /// v_s of contact k in slip, times its direction; `slope` is dx/dt.
  static double slip(Motion& m, int k, const Vector& x, const Vector& slope, double t) {
    const auto& c = m.f.contacts()[k];
    const double acceleration = -gap_acceleration(m, k, x, slope, t);
    const auto& row = m.f.contact_rows.at(k, x, t);
    const double* v = x.data() + m.f.system().n();
    const double rate = -row.normal.dot(v), delta = std::max(0.0, -row.gap);
    // g and its derivative along the motion
    const auto dual_of = [](double x, double x_rate) {
      Dual<1> dual(x);
      dual.slope[0] = x_rate;
      return dual;
    };
    const auto g = c.force(dual_of(delta, rate), dual_of(rate, acceleration), Dual<1>(1));
    return c.zone * c.shear->slip(c.zone, delta, rate, g.value, g.slope[0], row.tangent.dot(v));
  }
  /// The acceleration that increases w while a contact is compressed (m/s²): dw²/dt = 2δ̇ (δ̈ +
  /// F_el/m), the external load less the damping.
  static double push(Motion& m, int k, const Vector& x, const Vector& slope, double t) {
    const double acceleration = -gap_acceleration(m, k, x, slope, t), gap = m.f.contact_rows.at(k, x, t).gap;
    const auto& c = m.f.contacts()[k];
    return acceleration + c.law.elastic.force(std::max(0.0, -gap)) / c.mass;
  }
  static double gap_acceleration(Motion& m, int k, const Vector& x, const Vector& slope, double t) {
    const auto& row = m.f.contact_rows.at(k, x, t);
    return row.normal.dot(slope.data() + m.f.system().n()) - row.gamma_n;
  }

  MotionBounds bounds_;  // of the last step
  Limits limits_;
  double unseen_ = 0;  // greatest, over the clearance
};

}  // namespace freeplay
