// EndRates: corrects the velocities after a smooth step to the rates at its end. The rates at the
// middle of a step, extrapolated by ±(h/2)γ, have a third-order error at its end, which would let a
// lasting contact with a rotating normal separate. The correction is the least mass-weighted change
// of v such that joints, pressed contacts and sticking contacts have their prescribed rates at q⁺.
// For sliding contacts the error is of second order, because γ is that of v⁻. The correction of
// their normal rate therefore includes the friction impulse, W_N + (P_T/P_N) W_T; otherwise the
// error of a run would be of first order.
#pragma once

#include <vector>

#include "formulations/time_stepping/step_problem.hpp"
#include "formulations/time_stepping/step_results.hpp"

namespace freeplay {

class EndRates {
 public:
  /// `rows`: number of rows of all contacts and friction elements.
  EndRates(const System& system, int rows);
  /// Called with step.end evaluated at q. Adds its impulses to those of the contacts, to the
  /// energies and, if forces are observed, to the forces. Returns false with the reason in
  /// StepData::failure.
  bool meet(StepData& step, ContactSet& contacts, const StepProblem& problem, ImpulseResponses& responses,
            StepForces& forces);

 private:
  /// A row whose rate has to vanish, and the friction impulse with it.
  struct Row {
    double least = 0;  // N s: lower bound of its impulse
    double slope = 0;  // ratio of the friction impulse along `beside` to the normal impulse
    // for a sticking contact, the unknown whose friction bounds the impulse along this row; −1:
    // none
    int held = -1;
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
  ContactRow row_;  // of the present contact or joint
  std::vector<double> v_, lambda_;
};

}  // namespace freeplay
