// Variation: derivatives of an event-driven motion with respect to parameters p and to the initial
// state. With x the integrated vector, S = dx/dp has one column per parameter.
//
//     in a mode:     Ṡ = f_x S + f_p
//     at an event    h(x, t; p) = 0:     dt = −(h_x S⁻ + h_p)/ḣ⁻
//                    x⁺ = J(x⁻, t; p):   S⁺ = J_x (S⁻ + f⁻ dt) + J_t dt + J_p − f⁺ dt
//
// f⁻ and f⁺ are the right-hand sides before and after the event (saltation: Leine and Nijmeijer,
// Dynamics and Bifurcations of Non-Smooth Mechanical Systems, 2004, section 7). J is the projection
// onto the mode before, followed by the impact of the same contacts.
//
// f_x S is exact to rounding (event_jacobian.cpp). Ṡ is integrated by the stages of Dormand and Prince
// that the motion itself takes, so that S is the derivative of the computed motion at fixed step
// lengths. Derivatives with respect to p at a fixed state, and those of h and J, are differences of
// fourth order of closed forms at a fixed mode (differences.hpp). For this, each parameter has four
// systems with displaced values, and closer ones where a kink is within the first. No trajectory is
// differenced.
//
// A column ends where there is no derivative, with a reason (refuse()). A stepper owns a Variation only
// if derivatives are requested; the motion is bitwise identical to one without it.
#pragma once

#include <algorithm>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "formulations/event_driven/event_dynamics.hpp"
#include "formulations/event_driven/event_impacts.hpp"
#include "formulations/variation/sensitivity.hpp"
#include "formulations/variation/varied_columns.hpp"

namespace freeplay {

/// Value of a column of trajectory.csv or forces.csv at a state in the present mode.
double observed(const Column& column, EventDynamics& f, const std::vector<double>& x, double t);

/// Contacts at rest without load are open, because they have no force.
inline void take_varied_mode(EventDynamics& f, const EventDynamics& dynamics) {
  f.take_mode(dynamics);
  for (auto& c : f.contacts) c.resting = false;
}
inline double curved_length(const EventDynamics&, const std::vector<double>&, double length) {
  return length;
}
inline double curved_speed(const EventDynamics& f, const std::vector<double>& x) {
  return std::max(f.greatest(x.data() + f.system.n()), f.speed_scale());
}
inline double further_spacing(const EventDynamics&, const std::vector<double>&, const std::vector<double>&) {
  return 0;
}

class Variation : public VariedColumns<EventDynamics> {
 public:
  /// An event as the stepper processed it.
  struct ProcessedEvent {
    ModeEvent event;
    double t = 0;
    const Vector& before;               ///< x⁻, before the projection
    const Vector& after;                ///< x⁺
    const std::vector<int>& in_impact;  ///< contacts of the impact; empty without one
    const std::vector<int>& ended;      ///< those whose accumulation of bounces ends here
    const EventImpacts& impacts;
  };

  /// `integrands`: columns whose means are needed; `length` (m) and `duration` (s): scales over which
  /// functions of the state and of time are curved.
  Variation(const EventDynamics& dynamics, const std::vector<VariedKey>& keys, std::vector<Column> integrands,
            double length, double duration);

  /// From now on the variational equations are evaluated by traced equations where that is possible. They
  /// are traced near a state, such as the start.
  void trace(TracedEquations& traced, const State& near) {
    probe_->use_tangent(traced.of(probe_->system, keys_, near, SystemTangent::Use::modes));
  }
  /// Advances S over a step of constant mode.
  void advance(const EventDynamics& dynamics, double t_old, const Vector& x_old, double t);
  /// Keeps the mode before an event.
  void begin_event(const EventDynamics& dynamics);
  void cross_event(const EventDynamics& dynamics, const ProcessedEvent& passed);
  /// Continues with the columns of time stepping: the next event is no start, even if it has no kind.
  void continue_from(const Variation& stepped) {
    take_columns(stepped);
    mode_known_ = false;
    continued_ = true;
  }
  /// Called at each event, with the dynamics in the mode after it.
  std::function<void(const EventDynamics&, const ProcessedEvent&)> on_event;
  /// Errors of impacts, to which the columns respond as to those of a parameter.
  std::function<ImpactError(int contact)> impact_error;
  /// Projects the columns onto the constraints of the present mode, as the motion is projected: removes
  /// their drift. x and t are the present ones.
  void project_columns(const EventDynamics& dynamics, const Vector& x, double t);
  /// Sum of the energies lost in contacts, which x does not contain.
  const Vector& contact_loss() const { return loss_; }

 protected:
  Function jump_of(const std::vector<int>& in_impact, const std::vector<int>& ended) const;
  void take_mode(const EventDynamics& dynamics) {
    VariedColumns::take_mode(dynamics);
    mode_known_ = true;
  }
  void set_times(EventMap& e, const ModeEvent& event);
  void jump(const EventMap& e, const std::vector<int>& in_impact, const std::vector<int>& ended);
  void cross_impacts(const EventDynamics& d, const ProcessedEvent& p, EventMap e,
                     const std::vector<int>& onsets);
  void keep_start(const EventDynamics& d, const ProcessedEvent& p);
  bool coupled(const Vector& x, double t, const std::vector<int>& ended, const std::vector<int>& onsets,
               const std::vector<int>& closed);
  double change_by_order(const ProcessedEvent& p, int a, int b, const std::vector<int>& closed);

 private:
  std::unique_ptr<EventDynamics> after_;  // of the nominal system, in the mode after an event
  Vector loss_;                           // d(energy lost in contacts)/dp
  bool mode_known_ = false, continued_ = false;
};

}  // namespace freeplay
