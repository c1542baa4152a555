// What a step's impulses are to the log of contact events: a first contact at the time at which the gap closes, a separation at the
// end of the last step with an impulse; and the change of the velocities that the step's impacts made, as sensors feel it.
#pragma once

#include <array>
#include <vector>

#include "formulations/time_stepping/step_problem.hpp"
#include "simulation/formulation.hpp"

namespace freeplay {

class ContactRecord {
 public:
  /// `step`: s, of fixed steps, 0 of adaptive ones.
  ContactRecord(const System& system, double step) : step_(step), v_(system.n()) {}
  void start() { flights_.fill(INFINITY); }

  void record(StepData& step, ContactSet& contacts, StepProblem& problem, const ImpulseResponses& responses);
  /// Logs the separation of contacts that are no longer closed, which the next step would do.
  void leave_all_open(StepData& step, ContactSet& contacts);
  /// A contact came into impact in the last step.
  bool struck() const { return struck_; }
  /// The impacts of the last step, at the mean of their times by normal impulse.
  Struck impacts(double t) const {
    if (!struck_) return {t, {}};
    return {t_, v_};
  }
  /// Steps of the shortest flight, by the binary exponent of the approach that it ended with.
  std::array<double, 128>& flights() { return flights_; }

 private:
  bool leaves(const StepData& step, const StepContact& c) const;
  void log_leave(StepData& step, ContactSet& contacts, int k);
  void keep_impacts(const StepData& step, const ContactSet& contacts, const StepProblem& problem,
                    const ImpulseResponses& responses);
  void keep_flight(double approach, double steps, Extremes& extremes);

  double step_;
  bool struck_ = false;
  double t_ = 0;           // s
  std::vector<double> v_;  // what the impacts did to the velocities
  std::array<double, 128> flights_;
};

}  // namespace freeplay
