// Velocities after a smooth step meet the rates at its end. Rates at the middle of a step, continued by ±(h/2)γ, miss those at its
// end by an error of third order, by which what stays in contact on a turning normal would lift off: least mass-weighted change of v
// onto the rates at q⁺ of joints, of what is pressed and of what sticks. Of what slides the error is of second order, γ
// being that of v⁻: friction has its share of what brings its normal rate back, W_N + (P_T/P_N) W_T, or it would be of first
// order over a run.
#pragma once

#include <vector>

#include "formulations/time_stepping/step_forces.hpp"
#include "formulations/time_stepping/step_problem.hpp"

namespace freeplay {

class EndRates {
 public:
  /// `rows`: of all contacts and friction elements.
  EndRates(const System& system, int rows);
  /// With step.end placed at q. Adds its impulses to the contacts' episodes, to the energies and, where watched, to the
  /// forces. A failure stands in StepData::failure.
  bool meet(StepData& step, ContactSet& contacts, const StepProblem& problem, ImpulseResponses& responses,
            StepForces& forces);

 private:
  /// A row whose rate is to vanish, and friction's share beside it.
  struct Row {
    double least = 0;    // N s: how far back its impulse may go
    double slope = 0;    // friction's impulse over the normal one, along `beside`
    int held = -1;       // the unknown whose friction holds what slides along this row, −1: none
    double impulse = 0;  // N s
    SparseRow beside;
  };
  template <class Visit>
  void each_pressed(const StepData& step, const ContactSet& contacts, const StepProblem& problem,
                    Visit visit);
  template <class Visit>
  void each_sticking_joint(const StepData& step, const StepProblem& problem, Visit visit);
  void take(ImpulseResponses& responses, const SparseRow& row, double least);
  void collect(StepData& step, const ContactSet& contacts, const StepProblem& problem,
               ImpulseResponses& responses);
  void respond(StepData& step, ImpulseResponses& responses);
  bool sweep(StepData& step, const StepProblem& problem, const ImpulseResponses& responses);
  void find_impulses(StepData& step, const StepProblem& problem, ImpulseResponses& responses);
  void report(StepData& step, const ContactSet& contacts, const StepProblem& problem,
              ImpulseResponses& responses, Forces& out);

  std::vector<Row> rows_;
  int used_ = 0;
  ContactRow row_;  // of the contact or joint that is looked at
  std::vector<double> v_, lambda_;
};

}  // namespace freeplay
