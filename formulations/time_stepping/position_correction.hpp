// PositionCorrection: projects positions at the end of a step onto Φ = 0 and g ≥ 0 by the least
// mass-weighted displacement; velocities do not change. One Newton step onto Φ(q⁺, t⁺) = 0 is
// followed by a contact problem that opens negative gaps along A W_N, which conserves Φ to first
// order,
//
//     0 ≤ g + W_Nᵀ Δq ⊥ p ≥ 0,   Δq = A W_N p
//
// With many contacts, lasting contacts of joints with clearance are first corrected to g = 0 from
// either side, like joints.
#pragma once

#include <memory>
#include <vector>

#include "formulations/contact/contact_islands.hpp"
#include "formulations/time_stepping/step_problem.hpp"

namespace freeplay {

class PositionCorrection {
 public:
  PositionCorrection(const StepData& step, double tolerance, bool many);

  /// `problem`: the problem of the step with its impulses. Afterwards, step.end is evaluated at q,
  /// and the gaps of all contacts are set.
  void bring_back(StepData& step, ContactSet& contacts, const StepProblem& problem,
                  ImpulseResponses& responses, FilmStep& films);
  long& modes_left() { return problem_.modes_left; }

 private:
  void add(const StepContact& contact, int place);
  bool hold_lasting(StepData& step, ContactSet& contacts, const StepProblem& problem,
                    ImpulseResponses& responses);
  void open_gaps(StepData& step, ContactSet& contacts, const StepProblem& problem,
                 ImpulseResponses& responses, bool films);
  ContactSolution solve(const ImpulseResponses& responses);
  static void report(StepData& step, double residual);
  void compromise(StepData& step, const ImpulseResponses& responses);
  void draw_closed(StepData& step, ContactSet& contacts, const StepProblem& problem,
                   ImpulseResponses& responses);
  int place(int row) const { return islands_ ? place_[row] : row; }

  double tolerance_;
  ContactProblem problem_;
  std::unique_ptr<ContactIslands> islands_;  // with many contacts
  std::vector<int> place_, id_;              // with many contacts: of each row and of each unknown
};

}  // namespace freeplay
