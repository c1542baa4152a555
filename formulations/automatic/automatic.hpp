// The automatic scheme, the default of the nonsmooth formulation. It runs the event-driven scheme
// as long as that can resolve events one by one, and hands over to adaptive time stepping where it
// cannot: at accumulations of impacts, in modes of many contacts that change repeatedly, and in
// Painlevé's configurations. It returns to the event-driven scheme once no impact has occurred for
// a while, with a tenth of the tolerance of the time steps, because the state is not known more
// accurately than that. handover.hpp has the rules.
//
// AutomaticStepper owns both schemes, which share one contact log. A handover passes the state,
// energies, extremes, counts of work and open contacts, so that the only error is each scheme's own
// tolerance. If the event-driven scheme cannot make a step, time stepping makes it from the same
// state.
#pragma once

#include <array>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "formulations/automatic/handover.hpp"
#include "formulations/event_driven/event_driven.hpp"
#include "formulations/time_stepping/adaptive.hpp"
#include "formulations/variation/step_variation.hpp"

namespace freeplay {

class AutomaticStepper {
 public:
  /// `after`: tolerance of the steps of `events` once `stepping` has advanced the state.
  AutomaticStepper(EventDriven events, AdaptiveMoreau stepping, double after);

  void start(const State& state, ContactLog& log);
  bool step(double t_end);
  const std::string& failure() const { return failure_; }

  /// @name Derivatives of the motion; call vary() after start()
  ///@{
  void vary(const std::vector<VariedKey>& keys, std::vector<Column> integrands, double length,
            double duration);
  /// The schemes with their derivatives; the second one where time_steps() is true.
  EventDriven& events() { return events_; }
  StepVariation& stepped() { return *stepped_; }
  const EventDynamics& stepped_mode() const { return *stepped_mode_; }
  /// Whether time stepping makes the next step.
  bool time_steps() const { return steps_; }
  ///@}

  template <class M>
  void serialize(M& m) {
    m.part("automatic");
    m(events_, stepping_, steps_, shown_, times_, in_impact_, shrinkage_, costs_);
  }

  double t() const { return shown_ ? stepping_.t() : events_.t(); }
  double t_old() const { return shown_ ? stepping_.t_old() : events_.t_old(); }
  const double* v() const { return shown_ ? stepping_.v() : events_.v(); }
  const double* v_old() const { return shown_ ? stepping_.v_old() : events_.v_old(); }
  const double* q() const { return shown_ ? stepping_.q() : events_.q(); }
  std::span<const double> z() const { return shown_ ? stepping_.z() : events_.z(); }
  void hold(std::span<const double> z) {
    if (shown_ || steps_) stepping_.hold(z);
    if (!steps_) events_.hold(z);
  }
  std::span<const double> multipliers() const {
    return shown_ ? stepping_.multipliers() : events_.multipliers();
  }
  void interpolate(double t, double* q, double* v) const {
    shown_ ? stepping_.interpolate(t, q, v) : events_.interpolate(t, q, v);
  }
  StepImpacts in_impact() const { return shown_ ? stepping_.in_impact() : StepImpacts{t(), {}}; }

  /// @name Forces; see Step
  ///@{
  void watch_forces(bool on);
  void forces(double t, Forces& out) { shown_ ? stepping_.forces(t, out) : events_.forces(t, out); }
  void add_impulse(double a, double b, Forces& sum) {
    shown_ ? stepping_.add_impulse(a, b, sum) : events_.add_impulse(a, b, sum);
  }
  const Forces& before() const { return shown_ ? in_impact_ : events_.before(); }
  const Forces& within() const { return shown_ ? stepping_.within() : events_.within(); }
  ///@}
  std::array<double, 2> outside_work() const {
    return shown_ ? stepping_.outside_work() : events_.outside_work();
  }
  EnergyLedger integrals() const { return shown_ ? stepping_.integrals() : events_.integrals(); }
  const Extremes& extremes() const { return shown_ ? stepping_.extremes() : events_.extremes(); }
  const Work& work() const { return shown_ ? stepping_.work() : events_.work(); }
  double unseen() const { return std::max(events_.unseen(), stepping_.unseen()); }
  bool singular() const { return events_.singular() || stepping_.singular(); }
  double nearest_singular() const {
    return std::min(events_.nearest_singular(), stepping_.nearest_singular());
  }
  void add_notes(std::vector<std::string>& notes) const;

 private:
  const char* gives_up();
  void pass_on(const std::string& why);
  void return_to_events();
  SchemeProgress progress() const {
    return {steps_ ? stepping_.t() : events_.t(),
            (steps_ ? stepping_.work() : events_.work()).factorisations};
  }

  EventDriven events_;
  AdaptiveMoreau stepping_;
  ContactLog* log_ = nullptr;
  bool steps_ = false;  // time stepping makes the next step
  bool shown_ = false;  // time stepping made the last step
  HandoverTimes times_;
  StepShrinkage shrinkage_;
  SchemeCosts costs_;
  double after_;
  bool watching_ = false;
  Forces in_impact_;  // impulses that the event-driven scheme applied before it gave up
  std::string failure_;
  std::unique_ptr<EventDynamics> stepped_mode_;  // both are null unless derivatives are requested
  std::unique_ptr<StepVariation> stepped_;
};

}  // namespace freeplay
