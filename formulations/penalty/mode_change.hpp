// ModeChange: changes of mode where a step of the penalty formulation ends at an event. It records contact
// events, and owns what follows from successive events: whether friction changes its zone at every step.
#pragma once

#include "formulations/penalty/penalty_motion.hpp"
#include "formulations/penalty/step_findings.hpp"

namespace freeplay {

template <class Method>
class ModeChange {
 public:
  using Motion = PenaltyMotion<Method>;

  void start(ContactLog& log) { log_ = &log; }
  /// Changes the mode at an event, and that of contacts whose gaps reach zero at the same instant, up to
  /// rounding: these are part of the same event.
  void change(Motion& m, const PenaltyEvent& event, FixedStepErrors& errors) {
    m.restart = true;
    change_mode(m, event, errors);
    if (event.contact >= 0) change_coincident(m, event, errors);
    inform_method(m, event);
  }
  /// If the watched value was outside its zone at both ends of a step, it takes its actual zone.
  static void follow_zone(Motion& m, int k) {
    const auto& c = m.f.contacts()[k];
    if (c.shear && c.zone != 0) return;
    const auto [low, high] = c.zone_ends();
    const double slide = m.mark[k].at.slide;
    if (slide >= low - c.zone_tolerance() && slide <= high + c.zone_tolerance()) return;
    enter_zone(m, k, slide);
    m.restart |= c.shear.has_value();  // its rate jumps, which that of a coefficient does not
  }
  void close(Motion& m, int k) {
    auto& c = m.f.contacts()[k];
    const auto& row = m.f.contact_rows.at(k, m.method.x, m.method.t);
    const double rate = row.normal.dot(m.v()), slide = row.tangent.dot(m.v());
    c.closed = true;
    c.v0 = std::max(-rate, m.v0_floor);
    c.mass = m.f.effective_mass(row);
    c.in_impact = false;
    // closed without an impact
    c.eased = -rate < m.v0_floor || m.unloaded[static_cast<std::size_t>(k)];
    const int p = m.f.impulse_offset() + 2 * k;
    m.mark[k] = {{row.gap, rate, slide}, m.method.x[p], m.method.x[p + 1], m.method.t};
    if (c.friction) c.zone = c.friction->zone(slide);
    if (m.f.bristles()) m.method.x[m.f.bristle_offset() + k] = 0;
    if (c.shear) {
      // A contact that is compressed already has an undeformed spring.
      const bool onset = -row.gap <= 64 * gap_rounding(m.f.system(), k, m.q());
      c.zone = onset ? c.shear->first_zone(-rate, c.force(0.0, -rate, 1.0), slide) : 0;
      m.mark[k].at = m.sampled(k, row, m.method.x);
    }
    const double duration = elastic_duration(c.law.elastic, c.mass, c.v0);
    log_->record_onset(k, m.method.t, m.crank(), rate, slide, 4e-16 * m.method.t, 4 * duration);
    m.restart = true;
    m.method.limit_step(0.05 * duration);
  }

  template <class M>
  void serialize(M& m) {
    m(last_slide_, chatter_);
  }

 private:
  void change_mode(Motion& m, const PenaltyEvent& event, FixedStepErrors& errors) {
    using Kind = PenaltyEvent::Kind;
    if (event.limit.found() || event.kind == Kind::clamp) return;
    if (event.contact < 0) return m.f.phases.cross(m.f.system(), event.crossing);
    const auto& c = m.f.contacts()[event.contact];
    if (event.kind == Kind::impact) return apply_impact(m, event.contact);
    if (event.kind == Kind::gap) return c.closed ? open(m, event.contact, errors) : close(m, event.contact);
    const bool up = event.boundary == c.zone_ends().high;
    enter_zone(m, event.contact, event.boundary + (up ? c.zone_tolerance() : -c.zone_tolerance()));
  }
  void change_coincident(Motion& m, const PenaltyEvent& first, FixedStepErrors& errors) {
    for (int k = 0; k < m.f.system().contacts(); ++k) {
      if (k == first.contact) continue;
      const auto at = m.watched(k, m.mark[k].at);
      if (at.value > 4 * gap_rounding(m.f.system(), k, m.q()) || !(at.rate < 0)) continue;
      ++m.f.work.events;
      m.f.contacts()[k].closed ? open(m, k, errors) : close(m, k);
    }
  }
  void open(Motion& m, int k, FixedStepErrors& errors) {
    const auto& row = m.f.contact_rows.at(k, m.method.x, m.method.t);
    const double rate = row.normal.dot(m.v()), slide = row.tangent.dot(m.v());
    m.f.contacts()[k].closed = false;
    const int p = m.f.impulse_offset() + 2 * k;
    if constexpr (Method::fixed_step)
      errors.keep_contact(m.method.length(), m.method.t - m.mark[k].t,
                          std::abs(m.method.x[p] - m.mark[k].impulse_n) / m.f.contacts()[k].mass);
    log_->record_separation(k, m.method.t, m.crank(), rate, slide, m.method.x[p] - m.mark[k].impulse_n,
                            m.method.x[p + 1] - m.mark[k].impulse_t, m.method.t - m.mark[k].t);
    m.mark[k].at = {row.gap, rate, slide};
  }
  /// An impact on a closed contact begins, or ends and sets v₀.
  static void apply_impact(Motion& m, int k) {
    auto& c = m.f.contacts()[k];
    const auto& row = m.f.contact_rows.at(k, m.method.x, m.method.t);
    if (!c.in_impact) c.mass = m.f.effective_mass(row);
    c.v0 = std::max(m.touch_speed(c, m.mark[k].at), m.v0_floor);
    c.in_impact = !c.in_impact;
  }
  /// The zone of contact k's friction beyond the value `slide` of its watched function.
  static void enter_zone(Motion& m, int k, double slide) {
    auto& c = m.f.contacts()[k];
    if (!c.shear) {
      c.zone = c.friction->zone(slide);
      return;
    }
    // Between stick and slip the force is continuous.
    if (c.zone != 0) {
      const auto& s = m.mark[k].at;
      m.method.x[m.f.bristle_offset() + k] = c.zone * c.shear->mu * c.normal_force(s.gap, s.rate);
    }
    c.zone = c.zone != 0 ? 0 : slide > 0 ? 1 : -1;
    m.mark[k].at = m.sample_end(k);
  }
  /// Informs the method of a new mode. A sliding speed that leaves one zone after another with
  /// hardly a step between is caused by a step that is too long.
  void inform_method(Motion& m, const PenaltyEvent& event) {
    const bool soon = event.kind == PenaltyEvent::Kind::slide && m.f.work.steps - last_slide_ <= 4;
    chatter_ = soon ? chatter_ + 1 : 0;
    if (event.kind == PenaltyEvent::Kind::slide) last_slide_ = m.f.work.steps;
    if (chatter_ >= 30)
      m.method.relieve();
    else
      m.method.new_mode();
  }

  ContactLog* log_ = nullptr;
  long last_slide_ = 0;  // step
  int chatter_ = 0;
};

}  // namespace freeplay
