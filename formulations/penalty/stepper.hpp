// PenaltyStepper: steps of the penalty formulation. A step of the integration method in the present
// mode is followed by a search for contact events within it. If there is one, the step is repeated to
// end exactly at the first event, and the mode changes there. The stepper owns the data of the step and
// calls its parts, which get these data as an argument:
//
//   PenaltyMotion     the mechanism in its mode, the method, contacts at the ends of the step
//   PenaltySearch     finds the first event of a step, and repeats the step to end there
//   ModeChange        changes the mode, and records contact events
//   PenaltyPace       finds out whether steps make progress
//   PenaltyForces     evaluates forces for observers
//   FixedStepErrors   errors of fixed steps, for notes
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <span>
#include <string>

#include "formulations/integrators/curve_limit.hpp"
#include "formulations/integrators/peak_limit.hpp"
#include "formulations/penalty/mode_change.hpp"
#include "formulations/penalty/penalty_forces.hpp"
#include "formulations/penalty/penalty_motion.hpp"
#include "formulations/penalty/penalty_search.hpp"
#include "formulations/penalty/step_findings.hpp"
#include "simulation/force_integral.hpp"
#include "simulation/residuals.hpp"

namespace freeplay {

template <class Method>
class PenaltyStepper {
 public:
  /// `pace`: characteristic time of the scene (s), Scales::time.
  PenaltyStepper(PenaltyDynamics dynamics, Method method, double v0_floor, double pace)
      : m_(std::move(dynamics), std::move(method), v0_floor),
        peaks_(m_.f.system()),
        pace_(pace, m_.f.system().contacts()),
        forces_(m_.mark.size()) {
    extremes_.penetration.assign(m_.mark.size(), 0);
  }

  void start(const State& state, ContactLog& log) {
    modes_.start(log);
    std::ranges::fill(m_.scratch, 0);
    std::ranges::copy(state.q, m_.scratch.begin());
    std::ranges::copy(state.v, m_.scratch.begin() + m_.f.system().n());
    std::ranges::copy(state.z, m_.scratch.begin() + m_.f.state_offset());
    for (auto& c : m_.f.contacts()) c.closed = false;
    m_.f.phases.start(m_.f.system(), state.q.data(), state.v.data());
    m_.method.start(m_.f, state.t, m_.scratch);
    m_.f.place_end(m_.method.x, state.t);
    for (int k = 0; k < m_.f.system().contacts(); ++k) m_.mark[k].at = m_.sample_end(k);
    search_.find_unloaded(m_);
    for (int k = 0; k < m_.f.system().contacts(); ++k)
      if (m_.watched(k, m_.mark[k].at).value < 0 || (m_.mark[k].at.gap == 0 && m_.mark[k].at.rate < 0))
        modes_.close(m_, k);
    // Energy stored in contacts that are compressed at the start is not work of this run.
    m_.method.x[m_.f.integral_offset() + PenaltyDynamics::contact_work] =
        m_.f.elastic_energy(m_.method.x, state.t).dissipative;
  }
  /// After start(): closed contacts continue an earlier run, with the data that they retained there.
  void resume(const std::vector<PenaltyMode>& modes) {
    for (std::size_t k = 0; k < modes.size(); ++k) {
      auto& c = m_.f.contacts()[k];
      if (!c.closed || !modes[k].closed) continue;
      const int zone = c.zone;  // follows from the state
      c.mode() = modes[k];
      c.zone = zone;
    }
  }

  template <class M>
  void serialize(M& m) {
    m.part("penalty stepper");
    m(m_, search_, modes_, pace_, errors_, extremes_, lost_);
    forces_.serialize(m, m_.f, m_.f.system());
  }

  double t() const { return m_.method.t; }
  double t_old() const { return m_.method.t_old; }
  const double* q() const { return m_.q(); }
  const double* v() const { return m_.v(); }
  const double* v_old() const { return m_.v_old(); }
  void interpolate(double t, double* q, double* v) const {
    const int n = m_.f.system().n();
    const Vector* x = &m_.method.x;
    if (t < m_.method.t) {
      m_.method.show(t, static_cast<std::size_t>(n), m_.scratch);
      x = &m_.scratch;
    }
    std::copy(x->begin(), x->begin() + n, q);
    std::copy(x->begin() + n, x->begin() + 2 * n, v);
  }
  std::span<const double> z() const {
    return {m_.method.x.data() + m_.f.state_offset(), static_cast<std::size_t>(m_.f.system().states())};
  }
  void hold(std::span<const double> z) {
    std::ranges::copy(z, m_.method.x.begin() + m_.f.state_offset());
    m_.restart = true;
  }
  std::span<const double> multipliers() const { return m_.f.multipliers(); }

  /// @name Forces; see Step
  ///@{
  void watch_forces(bool on) { forces_.watch(on, m_.f, m_.f.system()); }
  void forces(double t, Forces& out) {
    if (t < m_.method.t)
      m_.method.show(t, static_cast<std::size_t>(m_.f.system().n()), m_.moving);
    else
      m_.moving = m_.method.x;
    forces_.at(m_.f, m_.moving, t, out);
  }
  void add_impulse(double a, double b, Forces& sum) { integrate_forces(*this, a, b, forces_.scratch(), sum); }
  const Forces& before() const { return forces_.before(); }
  const Forces& within() const { return forces_.within(); }
  ///@}

  bool step(double t_end) {
    auto& f = m_.f;
    auto& method = m_.method;
    forces_.keep_mode(f);
    const double run_end = t_end;
    // Knots of tables end steps, so that no step crosses a kink of a torque or misses a pulse.
    const double knot = f.knot = f.system().next_knot(method.t);
    // A jump of a prescribed acceleration at the knot belongs to the next step.
    if (f.system().has_motions()) f.knot = std::nextafter(knot, method.t);
    if (m_.restart) method.renew(f);
    m_.restart = false;
    search_.find_unloaded(m_);
    const bool to_knot = knot < t_end;
    if (to_knot) t_end = knot;
    t_end = std::min(t_end, method.t + longest_step(f.system(), v()));
    if (!step_within_curves(t_end)) return false;
    if (++f.work.steps % 100000 == 0) {
      const bool lasts = Method::may_creep && std::ranges::any_of(f.contacts(), &PenaltyContact::closed);
      if (pace_.creeps(method.t, lasts, f.work.events, run_end)) return false;
    }
    f.work.rejected = method.rejected;
    PenaltyEvent first;
    first.t = method.t;
    if (!search_.find_contact_event(m_, first)) return lose();
    if (Method::fixed_step && search_.slip_diverges(m_)) {
      method.start(f, method.t_old, Vector(method.x_old));
      method.relieve();
      return step(run_end);
    }
    search_.find_kink(m_, first);
    if constexpr (Method::fixed_step) errors_.keep_pulse(f.system(), method);
    const bool cut = first.found();
    if (cut) search_.land_on_first(m_, first);
    if (f.projects()) {
      f.project(method.x, method.t);
      forces_.keep_projection(f, method.x);
      m_.restart = true;
    }
    if (!std::isfinite(std::accumulate(method.x.begin(), method.x.end(), method.t))) return lose();
    keep_residuals(f.system(), f.evaluation(), extremes_);
    extremes_.friction_residual = f.reactive_friction().residual;
    keep_contacts(first, cut);
    if (cut) modes_.change(m_, first, errors_);
    if (to_knot && method.t >= knot) {
      method.limit_step(INFINITY);
      m_.restart = true;
    }
    return pace_.progresses(method.t_old, method.t, cut, run_end);
  }
  /// The reason why step() returned false.
  std::string failure() const {
    if (lost_)
      return fmt::format(
          "t = {:.9g} s: the state is no longer finite; use a smaller penalty.tolerance or penalty.step",
          t_old());
    if (m_.f.reactive_friction().trouble)
      return fmt::format("t = {:.9g} s: {}", t_old(), m_.f.reactive_friction().trouble);
    if (pace_.creeps())
      return fmt::format(
          "t = {:.9g} s: steps of {:.2g} s, the motion is too stiff for this integrator; use "
          "penalty.integrator = \"rosenbrock4\" or, for contacts from rest, a greater penalty.v0_floor",
          t(), t() - t_old());
    if (pace_.stalled())
      return fmt::format(
          "t = {:.9g} s: {} repeatedly without progress in time; use a smaller penalty.step or "
          "penalty.tolerance",
          t(),
          m_.f.system().contacts() > 0 ? "a contact opens and closes"
                                       : "an angle or a length crosses a kink of its table");
    return fmt::format(
        "t = {:.9g} s: every step is rejected, however small: the motion may be singular there (such as at "
        "a change point), or penalty.tolerance is below rounding error",
        t_old());
  }

  const PenaltyDynamics& dynamics() const { return m_.f; }
  const Vector& x() const { return m_.method.x; }
  const Vector& x_old() const { return m_.method.x_old; }
  /// How often an implicit step replaced the chosen method.
  long reliefs() const { return m_.method.reliefs(); }
  /// See PenaltySearch.
  double unseen() const { return search_.unseen(); }
  const FixedStepErrors& errors() const { return errors_; }
  EnergyLedger integrals() { return m_.f.ledger(m_.method.x, m_.method.t); }
  /// J, work of drives and of loads.
  std::array<double, 2> outside_work() const {
    const double* w = m_.method.x.data() + m_.f.integral_offset();
    return {w[PenaltyDynamics::drive], w[PenaltyDynamics::load]};
  }
  const Work& work() const { return m_.f.work; }
  const Extremes& extremes() const { return extremes_; }

 private:
  /// Makes a step of the method, not beyond t_end, that passes over no curve and no peak of friction. A fixed step is made
  /// as it is, and compared with the limit by its curves.
  bool step_within_curves(double t_end) {
    const double limit = curve_step_limit(m_.f.system(), m_.method.t, m_.q(), m_.v(), Knots::located);
    if constexpr (!Method::fixed_step) t_end = std::min(t_end, m_.method.t + limit);
    for (;;) {
      if (!m_.method.step(m_.f, t_end)) return false;
      const double h = m_.method.t - m_.method.t_old;
      const double beyond = curve_overreach(m_.f.system(), m_.method.t_old, m_.method.x_old.data(),
                                            m_.v_old(), m_.method.t, m_.q(), m_.v(), Knots::located);
      if constexpr (Method::fixed_step) {
        errors_.coarse = std::max({errors_.coarse, h / limit, beyond});
        return true;
      }
      const double over = std::max(beyond, peaks_.overreach(m_.method.t_old, m_.method.x_old.data(),
                                                            m_.v_old(), m_.method.t, m_.q(), m_.v()));
      if (!(over > 1)) return true;
      t_end = m_.method.t_old + h / over;
      if (!(t_end > m_.method.t_old)) return true;  // time resolves no shorter step
      ++m_.method.rejected;
      m_.scratch = m_.method.x_old;
      m_.method.start(m_.f, m_.method.t_old, m_.scratch);
    }
  }
  /// Contacts at the end of a step; `cut`: shortened to the event `first`.
  void keep_contacts(const PenaltyEvent& first, bool cut) {
    if (cut) m_.f.place_end(m_.method.x, m_.method.t);
    for (int k = 0; k < m_.f.system().contacts(); ++k) {
      const ContactSample before = m_.mark[k].at;
      if (cut) m_.end[k] = m_.sample_end(k);
      const auto& end = m_.mark[k].at = m_.end[k];
      auto& c = m_.f.contacts()[k];
      c.eased = c.eased || end.rate > 0;
      if (!c.closed) continue;
      const bool turned = before.rate < 0 && end.rate > 0;
      extremes_.penetration[k] =
          std::max(extremes_.penetration[k], -(turned ? search_.least_gap(m_, k, before) : end.gap));
      if (c.rubs() && first.contact != k) modes_.follow_zone(m_, k);
    }
  }
  /// Restores the last finite state.
  bool lose() {
    lost_ = true;
    m_.method.t = m_.method.t_old;
    m_.method.x = m_.method.x_old;
    return false;
  }

  PenaltyMotion<Method> m_;
  PenaltySearch<Method> search_;
  ModeChange<Method> modes_;
  PeakLimit peaks_;
  PenaltyPace pace_;
  PenaltyForces forces_;
  FixedStepErrors errors_;
  Extremes extremes_;
  bool lost_ = false;
};

}  // namespace freeplay
