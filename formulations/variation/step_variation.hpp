// StepVariation: derivatives of time stepping with steps h, fixed or adaptive, along its own trajectory.
//
// The derivative of the discrete map does not converge at impacts: a contact acts over whole steps, and the
// number of the step does not change with p. In its place, S = dx/dp follows the variational equations of
// the event-driven scheme (event_driven/variation.hpp). Each step is followed from its own beginning,
//
//     Ṡ = f_x S + f_p     from the stepped state, in the mode that the step's impulses show,
//
// and at a contact onset to the instant t* at which that motion closes the gap. There S jumps as at an event,
// with the impact law at that state, and Ṡ continues to the end of the step. The stepped state and this
// motion differ by O(h³) in a smooth step and by O(h) in a step with an impact; the next step begins at the
// stepped state, which has no derivative of its own. The error of S is therefore of first order in h; with
// adaptive steps, of the order of the tolerance that determines the steps over impacts.
//
// Modes: a contact is closed while its impulses follow each other step by step. If this begins with a contact
// onset, the accumulation of its bounces is shorter than a step, and the impact is without restitution.
// Where sliding ends, S jumps by saltation at the instant at which the motion from the beginning of the step
// ends it. Where a contact closes without approach, S is projected onto the new constraint by the least
// mass-weighted change.
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "formulations/automatic/handover.hpp"
#include "formulations/event_driven/variation.hpp"
#include "formulations/time_stepping/moreau.hpp"

namespace freeplay {

class StepVariation : public Variation {
 public:
  /// `mode`: the mechanism, whose mode follows the steps; it must outlive this object. `position_error`: gap
  /// (m) up to which a contact is closed at the start. Other arguments as for Variation.
  StepVariation(EventDynamics& mode, const std::vector<VariedKey>& keys, std::vector<Column> integrands,
                double length, double duration, double position_error);

  void start(const State& state);
  /// Continues from a state and the columns of the event-driven scheme, in its mode.
  void take_over(const Handover& from, const EventDynamics& mode, const Variation& events);
  /// After each step, which began at t_old. A step is followed once the next one is known.
  void end_step(const MoreauStepper& stepper, double t_old);
  /// After the last step.
  void finish();
  /// The vector at the end.
  const Vector& x() const { return x_; }

 private:
  /// A contact that opens for so many steps only, and closes slower than gravity-like accelerations explain,
  /// has not separated: the gap is rounding or the error of a step.
  static constexpr long unresolved_steps = 3;
  static constexpr double unresolved_flight = 3;  // steps
  // Newton's method in root_within(): iterations, and the last change over the interval or the duration.
  static constexpr int most_iterations = 12;
  static constexpr double root_change = 1e-8, time_rounding = 1e-15;
  struct Contact {
    bool pressed = false;  ///< has an impulse in this step
    bool onset = false;    ///< its first one
    int slip = 0;
    double t = 0, rate = 0, leaving = 0, impulse = 0;  ///< as the contact log has them
  };
  struct Step {
    double t_old = 0, t = 0;
    Vector x_old;
    std::vector<Contact> contacts;
    std::vector<int> slips;  ///< of joints with friction
  };
  struct Impact {
    int contact;
    double t;
    bool lasting;
  };
  Vector vector_of(const MoreauStepper& stepper) const;
  Step step_of(const MoreauStepper& stepper, double t_old) const;
  void follow(const Step& s, const Step* next);
  void close_at_start(const Step& s);
  void follow_phases(const Vector& x, double t, double h);
  void follow_limits(const Vector& x, double t, double h);
  void enter_mode(const Step& s, const Vector& x, double t);
  bool stays(const Step& s, int k, const Vector& x, double t);
  double end_sliding(const Step& s, Vector& x);
  double cross_onsets(const Step& s, const Step* next, Vector& x);
  bool closes_again(const Step& s, int k);
  void cross_impact(const Step& s, const Step* next, const Impact& impact, bool last, Vector& x);
  /// The time from t, at most `most` in either direction, at which a value with this rate vanishes on the
  /// motion from x, by Newton's method from tau.
  template <class Value>
  std::optional<double> root_within(const Vector& x, double t, double most, Value value, double tau = 0) {
    for (int i = 0; i < most_iterations; ++i) {
      const auto [y, rate] = value(tau == 0 ? x : flow(x, t, tau), t + tau);
      const double change = -y / rate;
      tau += change;
      if (!(std::abs(tau) <= most)) return {};
      if (std::abs(change) <= std::max(root_change * most, time_rounding * duration_)) return tau;
    }
    return {};
  }
  void project_columns(const Vector& x, double t);
  void advance(Vector& x, double& t, double to);
  void record(const Step& s, int k, const std::string& why);
  void begin_mode() { begin_event(mode_); }
  /// Passes an event without an impact at x, where the motion goes on.
  void cross_at(const Vector& x, const ModeEvent& event) {
    const std::vector<int> none;
    cross_event(mode_, {event, event.t, x, x, none, none, impacts_});
  }

  EventDynamics& mode_;
  EventImpacts impacts_;
  Vector x_;  // at the end of the last step
  std::optional<Step> last_;
  bool first_ = true;
  std::vector<int> at_start_;      // contacts that are closed at the start
  std::vector<long> last_closed_;  // number of the last step in which a contact was closed
  long count_ = 0;                 // of followed steps
  Vector demands_;                 // of controllers over their limits, at the beginning of the last step
};

}  // namespace freeplay
