// Energies of a step (values/ledger.hpp): works of its impulses on the mean of the velocities at
// its ends.
#pragma once

#include "formulations/time_stepping/step_problem.hpp"

namespace freeplay {

/// Adds a step's works to the totals. `in_impact`: it had impacts, whose energy gains are counted.
/// `fixed`: steps of fixed length. Sets step.v_mean to the mean velocity.
void account_step(StepData& step, const ContactSet& contacts, const StepProblem& problem,
                  const ImpulseResponses& responses, const FilmStep& films, bool in_impact, bool fixed);

}  // namespace freeplay
