// Results of a step: contact events (ContactRecord), forces (StepForces), energies (accumulate_energies()).
//
// ContactRecord: derives contact events from a step's impulses, and the velocity change by the
// step's impacts, which sensors measure. The time of a contact onset is the time at which the gap
// closes; a separation is at the end of the last step with an impulse.
#pragma once

#include <array>
#include <vector>

#include "formulations/time_stepping/step_problem.hpp"
#include "simulation/formulation.hpp"

namespace freeplay {

class ContactRecord {
 public:
  /// `step`: fixed step length (s), 0 for adaptive steps.
  ContactRecord(const System& system, double step) : step_(step), v_(system.n()) {}
  void start() { flights_.fill(INFINITY); }

  void record(StepData& step, ContactSet& contacts, StepProblem& problem, const ImpulseResponses& responses);
  /// Logs the separation of contacts that are no longer closed, as the next step would do.
  void leave_all_open(StepData& step, ContactSet& contacts);
  /// Whether an impact occurred in the last step.
  bool in_impact() const { return in_impact_; }
  /// The impacts of the last step, at the mean of their times weighted by normal impulse.
  StepImpacts impacts(double t) const {
    if (!in_impact_) return {t, {}};
    return {t_, v_};
  }
  /// The shortest flight in steps, by the binary exponent of the approach speed at its end.
  std::array<double, 128>& flights() { return flights_; }

 private:
  bool leaves(const StepData& step, const StepContact& c) const;
  void log_leave(StepData& step, ContactSet& contacts, int k);
  void keep_impacts(const StepData& step, const ContactSet& contacts, const StepProblem& problem,
                    const ImpulseResponses& responses);
  void keep_flight(double approach, double steps, Extremes& extremes);

  double step_;
  bool in_impact_ = false;
  double t_ = 0;           // s
  std::vector<double> v_;  // velocity change by the impacts
  std::array<double, 128> flights_;
};

/// StepForces: forces of a step, for observers. A step computes impulses; those of contacts in
/// impact, with the reactions of the joints to them, are separated from the rest. The forces of a
/// step are the remaining impulses divided by its length.
class StepForces {
 public:
  void watch(const System& system, bool on);
  bool watching() const { return watching_; }
  /// Collects the impulses of the step, at its middle.
  void collect(StepData& step, const ContactSet& contacts, const StepProblem& problem,
               ImpulseResponses& responses, const FilmStep& films);
  void at(double t_old, double t, Forces& out) const {
    out.clear();
    if (t > t_old) out.add(1 / (t - t_old), smooth_);
  }

  const Forces& nothing() const { return nothing_; }
  /// Impulses without the impacts (smooth) and of the impacts (within).
  Forces& smooth() { return smooth_; }
  const Forces& smooth() const { return smooth_; }
  const Forces& within() const { return within_; }

 private:
  bool watching_ = false;
  Forces nothing_, smooth_, within_;
  std::vector<double> impact_lambda_, smooth_lambda_;
};

// Energies of a step (values/ledger.hpp): works of its impulses on the mean of the velocities at
// its ends.

/// Adds a step's works to the totals. `in_impact`: it had impacts, whose energy gains are counted.
/// `fixed`: steps of fixed length. Sets step.v_mean to the mean velocity.
void accumulate_energies(StepData& step, const ContactSet& contacts, const StepProblem& problem,
                         const ImpulseResponses& responses, const FilmStep& films, bool in_impact,
                         bool fixed);

}  // namespace freeplay
