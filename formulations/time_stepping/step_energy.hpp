// The energies of a step (values/ledger.hpp): works of the impulses on the mean of the velocities at its ends.
#pragma once

#include "formulations/time_stepping/step_problem.hpp"

namespace freeplay {

/// Adds a step's works to the totals; `struck`: it had impacts, of which gains of energy are counted. `fixed`: of a given
/// length. Leaves the mean velocity in step.v_mean.
void account_step(StepData& step, const ContactSet& contacts, const StepProblem& problem,
                  const ImpulseResponses& responses, const FilmStep& films, bool struck, bool fixed);

}  // namespace freeplay
