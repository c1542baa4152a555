// PenaltyStepper: steps of the penalty formulation. A step of the integration method in the present
// mode is followed by a search for contact events within it (stepper_search.hpp). If there is one,
// the step is repeated to end exactly at the first event, and the mode changes there
// (stepper_modes.hpp). Who makes a stepper includes these two as well.
//
// It owns the dynamics, the method, the marks of all contacts and the diagnostics of the run.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <numbers>
#include <numeric>
#include <optional>
#include <span>
#include <string>

#include "formulations/integrators/crossing.hpp"
#include "formulations/integrators/curve_limit.hpp"
#include "formulations/integrators/kinks.hpp"
#include "formulations/integrators/methods.hpp"
#include "formulations/penalty/dynamics.hpp"
#include "formulations/probe.hpp"
#include "simulation/force_integral.hpp"
#include "simulation/residuals.hpp"

namespace freeplay {

template <class Method>
class PenaltyStepper {
 public:
  /// `pace`: characteristic time of the scene (s), Scales::time.
  PenaltyStepper(PenaltyDynamics dynamics, Method method, double v0_floor, double pace)
      : f_(std::move(dynamics)), method_(std::move(method)), v0_floor_(v0_floor), pace_(pace) {
    const int contacts = f_.system().contacts();
    mark_.resize(contacts);
    was_.resize(contacts);
    end_.resize(contacts);
    unloaded_.resize(static_cast<std::size_t>(contacts));
    seen_.resize(static_cast<std::size_t>(contacts));
    const int n = f_.system().n();
    for (int k = 0; k < contacts; ++k)
      for (const int body : f_.system().contact_facts(k).bodies)
        for (int c = 0; body != ground && c < planar::coordinates; ++c)
          for (const int at : {planar::first(body) + c, n + planar::first(body) + c})
            seen_[static_cast<std::size_t>(k)].push_back(at);
    for (int k = 0; f_.bristles() && k < contacts; ++k)
      seen_[static_cast<std::size_t>(k)].push_back(f_.bristle_offset() + k);
    for (auto* x : {&scratch_, &slope_, &moving_}) x->resize(f_.size());
    extremes_.penetration.assign(contacts, 0);
  }

  void start(const State& state, ContactLog& log);
  /// After start(): closed contacts continue an earlier run, with the data that they retained there.
  void resume(const std::vector<PenaltyMode>& modes);

  template <class M>
  void serialize(M& m) {
    m.part("penalty stepper");
    m(f_, method_, mark_, extremes_, restart_, stalled_, creeps_, lost_, creep_since_, events_since_,
      last_slide_, unseen_, chatter_, short_, pulses_, coarse_, paced_, paced_since_);
    serialize_probe(m, probe_, watching_, [this] { make_probe(); });
  }

  double t() const { return method_.t; }
  double t_old() const { return method_.t_old; }
  const double* v() const { return method_.x.data() + f_.system().n(); }
  const double* v_old() const { return method_.x_old.data() + f_.system().n(); }
  void interpolate(double t, double* q, double* v) const {
    const int n = f_.system().n();
    const Vector* x = &method_.x;
    if (t < method_.t) {
      method_.show(t, static_cast<std::size_t>(n), scratch_);
      x = &scratch_;
    }
    std::copy(x->begin(), x->begin() + n, q);
    std::copy(x->begin() + n, x->begin() + 2 * n, v);
  }

  const double* q() const { return method_.x.data(); }
  std::span<const double> z() const {
    return {method_.x.data() + f_.state_offset(), static_cast<std::size_t>(f_.system().states())};
  }
  std::span<const double> multipliers() const { return f_.multipliers(); }

  /// @name Forces; see Step
  ///@{
  void watch_forces(bool on) {
    watching_ = on;
    if (on && !probe_) make_probe();
  }
  void forces(double t, Forces& out) {
    if (t < method_.t)
      method_.show(t, static_cast<std::size_t>(f_.system().n()), moving_);
    else
      moving_ = method_.x;
    for (std::size_t k = 0; k < was_.size(); ++k) probe_->contacts()[k].mode() = was_[k];
    probe_->phases = was_phases_;
    probe_->knot = f_.knot;
    probe_->report(moving_, t, slope_, out);
  }
  void add_impulse(double a, double b, Forces& sum) { integrate_forces(*this, a, b, at_, sum); }
  const Forces& before() const { return nothing_; }
  const Forces& within() const { return within_; }
  ///@}

  bool step(double t_end) {
    if (watching_) keep_modes();
    const double run_end = t_end;
    // Knots of tables end steps, so that no step crosses a kink of a torque or misses a pulse.
    const double knot = f_.knot = f_.system().next_knot(method_.t);
    // A jump of a prescribed acceleration at the knot belongs to the next step.
    if (f_.system().has_motions()) f_.knot = std::nextafter(knot, method_.t);
    if (restart_) method_.renew(f_);
    restart_ = false;
    find_unloaded();
    const bool to_knot = knot < t_end;
    if (to_knot) t_end = knot;
    t_end = std::min(t_end, method_.t + longest_step(f_.system(), v()));
    if (!step_within_curves(t_end)) return false;
    if (++f_.work.steps % 100000 == 0 && (creeps_ = creep(run_end))) return false;
    f_.work.rejected = method_.rejected;
    Event first;
    first.t = method_.t;
    enclose();
    f_.place_end(method_.x, method_.t);
    for (int k = 0; k < f_.system().contacts(); ++k) {
      end_[k] = sample_end(k);
      if (!std::isfinite(end_[k].gap + end_[k].rate + end_[k].slide)) return lose();
      find_gap_event(k, first);
      find_slide_event(k, first);
      find_impact_event(k, first);
      find_clamp_event(k, first);
    }
    if (Method::fixed_step && leaps()) {
      method_.start(f_, method_.t_old, Vector(method_.x_old));
      method_.relieve();
      return step(run_end);
    }
    find_phase_event(first);
    find_limit_event(first);
    if constexpr (Method::fixed_step) keep_pulse();
    const bool cut = first.found();
    if (cut)
      land_on_first(
          method_, first, [&](Event& event) { land(event); },
          [&](const Event& landed) {
            Event lost;
            lost.t = method_.t;
            if (!enclose()) return lost;
            f_.place_end(method_.x, method_.t);
            for (int k = 0; k < f_.system().contacts(); ++k) {
              end_[k] = sample_end(k);
              if (k != landed.contact) find_gap_event(k, lost);
            }
            return lost;
          });
    if (f_.projects()) {
      f_.project(method_.x, method_.t);
      if (watching_) {
        within_.clear();
        f_.report_projection(method_.x, within_);
      }
      restart_ = true;
    }
    if (!std::isfinite(std::accumulate(method_.x.begin(), method_.x.end(), method_.t))) return lose();
    keep_residuals(f_.system(), f_.evaluation(), extremes_);
    extremes_.friction_residual = f_.friction_residual();
    if (cut) f_.place_end(method_.x, method_.t);
    for (int k = 0; k < f_.system().contacts(); ++k) {
      const Sample before = mark_[k].at;
      if (cut) end_[k] = sample_end(k);
      mark_[k].at = end_[k];
      f_.contacts()[k].eased = f_.contacts()[k].eased || end_[k].rate > 0;
      auto& c = f_.contacts()[k];
      if (!c.closed) continue;
      const bool turned = before.rate < 0 && end_[k].rate > 0;
      extremes_.penetration[k] =
          std::max(extremes_.penetration[k], -(turned ? least_gap(k, before) : end_[k].gap));
      if (c.rubs() && first.contact != k) follow_zone(k);
    }
    if (first.found()) change_mode(first);
    if (first.contact >= 0) change_coincident(first);
    if (first.found()) inform_method(first);
    if (to_knot && method_.t >= knot) {
      method_.limit_step(INFINITY);
      restart_ = true;
    }
    return progresses(first.found(), run_end);
  }
  /// The reason why step() returned false.
  std::string failure() const;

  const PenaltyDynamics& dynamics() const { return f_; }
  const Vector& x() const { return method_.x; }
  const Vector& x_old() const { return method_.x_old; }
  /// How often an implicit step replaced the chosen method.
  long reliefs() const { return method_.reliefs(); }
  /// Greatest possible depth of an undetected contact between the evaluated times, over its
  /// clearance; 0: excluded.
  double unseen() const { return unseen_; }
  /// Greatest change of a speed by the change of its acceleration in one step, over the greatest
  /// speed (fixed steps, tables).
  double pulse() const {
    double most = 0;
    for (const auto& p : pulses_) most = std::max(most, p.change > 0 ? p.change / p.speed : 0);
    return most;
  }
  /// Error of fixed steps in the impulses of short contacts: a half sine in n steps of fourth order
  /// has a relative error of (π/n)⁴/120, 4e-5 for n = 12.
  struct ShortContact {
    double lost = 0;      ///< m/s, the greatest error as a speed
    double duration = 0;  ///< s, duration of that contact
    double greatest = 0;  ///< m/s, greatest speed change by a contact
    template <class M>
    void serialize(M& m) {
      m(lost, duration, greatest);
    }
  };
  const ShortContact& short_contact() const { return short_; }
  /// Greatest length of a fixed step over the limit by the curves that it reads.
  double coarse() const { return coarse_; }
  EnergyLedger integrals() { return f_.ledger(method_.x, method_.t); }
  /// J, work of drives and of loads.
  std::array<double, 2> outside_work() const {
    const double* w = method_.x.data() + f_.integral_offset();
    return {w[PenaltyDynamics::drive], w[PenaltyDynamics::load]};
  }
  const Work& work() const { return f_.work; }
  const Extremes& extremes() const { return extremes_; }

 private:
  void make_probe() {
    probe_ = f_.twin();
    nothing_ = within_ = at_ = f_.system().make_forces();
  }
  /// Copies the modes of the next step.
  void keep_modes() {
    for (std::size_t k = 0; k < was_.size(); ++k) was_[k] = f_.contacts()[k].mode();
    was_phases_ = f_.phases;
  }
  /// Called after another hundred thousand steps: whether the run would never end. While a contact
  /// lasts without any event, only stability requires such short steps, and a hundred million of
  /// them are too many.
  bool creep(double run_end);
  /// Called after each step; false if many events or steps without length follow each other.
  bool progresses(bool event, double run_end);
  /// s: the time against which progress is measured, the rest of the run or a thousand times the
  /// characteristic time. A longer run takes more steps, and is no stiffer.
  double ahead(double run_end) const { return std::min(run_end - method_.t, 1000 * pace_); }
  /// Makes a step of the method, not beyond t_end, that passes over no curve. A fixed step is made
  /// as it is, and compared with the limit by its curves.
  bool step_within_curves(double t_end);
  /// Records how much the change of an angle's acceleration within the last step changes its speed,
  /// if a torque table acts on it: the error of a method without error control at a steep pulse.
  void keep_pulse();
  void keep_short_contact(double duration, double change);
  /// Restores the last finite state.
  bool lose() {
    lost_ = true;
    method_.t = method_.t_old;
    method_.x = method_.x_old;
    return false;
  }
  /// Coincident events take a step without length each.
  int most_stalled() const { return 10 + 2 * f_.system().contacts(); }
  struct Sample {
    double gap = 0, rate = 0;
    double slide = 0;  // sliding speed, or load of a tangential spring that sticks
    template <class M>
    void serialize(M& m) {
      m(gap, rate, slide);
    }
  };
  struct Mark {
    Sample at;                                   // end of the last step
    double impulse_n = 0, impulse_t = 0, t = 0;  // at contact onset
    template <class M>
    void serialize(M& m) {
      m(at, impulse_n, impulse_t, t);
    }
  };
  struct Event {
    int contact = -1;
    // slide: the sliding speed reaches `boundary`; impact: an impact on a closed contact
    // begins or ends; clamp: its force reaches zero, or leaves it
    enum class Kind { gap, slide, impact, clamp } kind = Kind::gap;
    double t = 0, boundary = 0;
    Phases::Crossing crossing = {};  // or an angle reaches a kink of its table
    Limits::Crossing limit = {};     // or the demand of a controller its limit
    bool found() const { return contact >= 0 || crossing.phase >= 0 || limit.found(); }
  };

  Sample sampled(int k, const ContactRow& row, const Vector& x) const {
    const double* v = x.data() + f_.system().n();
    Sample s{row.gap, row.normal.dot(v), row.tangent.dot(v)};
    const auto& c = f_.contacts()[k];
    if (c.shear && c.closed && c.zone == 0) [[unlikely]]
      s.slide = c.shear->load(c.normal_force(s.gap, s.rate), x[f_.bristle_offset() + k]);
    return s;
  }
  Sample sample(int k, const Vector& x, double t) { return sampled(k, f_.contact_row(k, x, t), x); }
  /// At the present state, which place_end() has evaluated.
  Sample sample_end(int k) { return sampled(k, f_.end_row(k, method_.x), method_.x); }
  Sample sample_at(int k, double t) {
    if (t >= method_.t) return end_[k];
    // With the two bodies of the contact only, because scenes of many contacts call this for each.
    if constexpr (Method::cubic) {
      method_.hermite(t, seen_[static_cast<std::size_t>(k)], scratch_);
      return sampled(k, f_.row_alone(k, scratch_), scratch_);
    }
    method_.interpolate(t, scratch_);
    return sample(k, scratch_, t);
  }
  /// Bounds the last step's motion; returns false if it has no length.
  bool enclose();
  /// Sets unloaded_ for the next step.
  void find_unloaded();
  /// Depth (m) below zero gap at which an unloaded contact closes. The force there is 1e-10 or less
  /// of that of an impact whose penetration is a thousandth of the clearance.
  double unloaded_gap(int k) const {
    return 1e-7 * f_.system().contact_facts(k).clearance + 64 * gap_rounding(f_.system(), k, q());
  }
  /// The value that is positive while the mode of contact k lasts.
  Watched watched(int k, const Sample& s) const {
    if (f_.contacts()[k].closed) return {-s.gap, -s.rate};
    return {s.gap + (unloaded_[k] ? unloaded_gap(k) : 0), s.rate};
  }
  /// Finds the first change of sign of contact k's gap in the last step before first.t. Called
  /// directly after end_[k] is set.
  void find_gap_event(int k, Event& first);
  void find_phase_event(Event& first);
  void find_limit_event(Event& first);

  /// Finds where the sliding speed of a closed contact leaves its zone within the step.
  void find_slide_event(int k, Event& first);
  /// Finds where a tangential spring that slips begins to stick within the step.
  void find_slip_end(int k, Event& first);
  /// The event of contact k where `value`, positive within its friction's zone, falls below zero.
  template <class F>
  void find_zone_end(int k, Event& first, double boundary, F value);
  /// v_s of contact k in slip, times its direction; `slope` is dx/dt.
  double slip(int k, const Vector& x, const Vector& slope, double t);
  /// The time at which the rate of contact k's gap vanishes in the last step, whose ends have
  /// opposite rates.
  double root_of_rate(int k, double rate);
  /// w of a closed contact (see contact_law.hpp).
  double touch_speed(const PenaltyContact& c, const Sample& s) const {
    return c.law.touch_speed(std::max(0.0, -s.gap), -s.rate, c.mass);
  }
  /// The acceleration that increases w while a contact is compressed (m/s²): dw²/dt = 2δ̇ (δ̈ +
  /// F_el/m), the external load less the damping.
  double push(int k, const Vector& x, const Vector& slope, double t);
  double gap_acceleration(int k, const Vector& x, const Vector& slope, double t);
  /// Least gap of contact k in the last step, in which its rate changed sign; `before` is its
  /// beginning. By the quintic through gaps, rates and accelerations at the ends, or by the
  /// method's own interpolant.
  double least_gap(int k, const Sample& before);
  /// Finds the beginning or end of an impact on a closed contact. It begins if the contact has a
  /// greater w than its v₀, or is compressed again. It ends if the load no longer exceeds the
  /// damping, or the contact expands. An impact that differs by less than a hundredth is the same.
  void find_impact_event(int k, Event& first);
  /// Fixed steps: finds where the force of a closed contact reaches zero, where it is clamped, or leaves zero
  /// again. Its kink there would limit their order.
  void find_clamp_event(int k, Event& first);
  struct Instant {
    double t = 0;
    Sample at = {};
  };
  /// The first such time between two times of the last step.
  std::optional<double> impact_between(int k, const Instant& before, const Instant& after);
  /// An impact on a closed contact begins, or ends and sets v₀.
  void apply_impact(int k);
  /// Whether a fixed step has changed a sliding speed that began in a steep zone of its friction
  /// law far beyond that zone. No motion does this: the step is unstable there.
  bool leaps() const;
  /// If the watched value was outside its zone at both ends of a step, it takes its actual zone.
  void follow_zone(int k);

  /// Repeats the step to end at the event.
  void land(Event& event);

  /// The zone of contact k's friction beyond the value `slide` of its watched function.
  void enter_zone(int k, double slide);
  void change_mode(const Event& event);
  /// Informs the method of a new mode. A sliding speed that leaves one zone after another with
  /// hardly a step between is caused by a step that is too long.
  void inform_method(const Event& event);
  /// Contacts whose gaps reach zero at the same instant, up to rounding, are part of the same
  /// event.
  void change_coincident(const Event& first);
  double crank() const { return f_.system().crank_angle(method_.x.data()); }

  void close(int k);
  void open(int k);
  double time_uncertainty() const { return 4e-16 * method_.t; }

  PenaltyDynamics f_;
  Method method_;
  MotionBounds bounds_;  // of the last step
  double v0_floor_, pace_;
  ContactLog* log_ = nullptr;
  std::vector<Mark> mark_;
  /// Open contacts whose gap, its rate and its acceleration are zero up to rounding at the
  /// beginning of the step: bodies in contact without load. Rounding changes the sign of such a gap
  /// repeatedly; this is no contact event.
  std::vector<char> unloaded_;
  std::vector<Sample> end_;  // of the whole step, before it is shortened to an event
  mutable Vector scratch_;
  Limits limits_;
  // components of the state on which a contact's gap and rates depend
  std::vector<std::vector<int>> seen_;
  Extremes extremes_;
  bool watching_ = false;
  std::unique_ptr<PenaltyDynamics> probe_;  // made when forces are first observed
  std::vector<PenaltyMode> was_;            // modes of the last step
  Phases was_phases_;
  Forces nothing_, within_, at_;
  Vector slope_, moving_;
  bool restart_ = false;  // the mode has changed since the last evaluation of the right-hand side
  int stalled_ = 0;
  bool creeps_ = false, lost_ = false;
  double unseen_ = 0;  // greatest, over the clearance
  ShortContact short_;
  struct Pulse {
    /// greatest change of the speed of a phase's argument in a step, and its greatest speed
    double change = 0, speed = 0;
    template <class M>
    void serialize(M& m) {
      m(change, speed);
    }
  };
  std::vector<Pulse> pulses_;
  double coarse_ = 0;
  int paced_ = 0;  // number of events since paced_since_
  double paced_since_ = -INFINITY;
  long last_slide_ = 0;  // step
  int chatter_ = 0;
  double creep_since_ = -INFINITY;
  long events_since_ = -1;
};

}  // namespace freeplay
