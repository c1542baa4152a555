// Positions at the end of a step are brought back to Φ = 0 and g ≥ 0 by the least mass-weighted movement, velocities untouched:
// one Newton step onto Φ(q⁺, t⁺) = 0, then contacts whose gap is still negative are opened along A W_N, which leaves Φ alone to
// first order,
//
//     0 ≤ g + W_Nᵀ Δq ⊥ p ≥ 0,   Δq = A W_N p
//
// With many contacts, those of loose joints that last are first brought to g = 0 from either side, as joints are.
#pragma once

#include <memory>
#include <vector>

#include "formulations/contact/contact_islands.hpp"
#include "formulations/time_stepping/step_problem.hpp"

namespace freeplay {

class PositionCorrection {
 public:
  PositionCorrection(const StepData& step, double tolerance, bool many);

  /// `problem`: the step's, with its impulses. Leaves step.end placed at q, and the gaps of all contacts.
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
  void compromise(StepData& step, const ImpulseResponses& responses);
  void draw_closed(StepData& step, ContactSet& contacts, const StepProblem& problem,
                   ImpulseResponses& responses);
  int place(int row) const { return islands_ ? place_[row] : row; }

  ContactProblem problem_;
  std::unique_ptr<ContactIslands> islands_;  // with many contacts
  std::vector<int> place_, id_;              // likewise, of each row and of each unknown
};

}  // namespace freeplay
