// Modes of contacts and joints with friction in the last step, and errors within a step that its
// impulses do not show. Adaptive time stepping uses both to estimate the error of a step.
#pragma once

#include <vector>

#include "formulations/time_stepping/step_problem.hpp"

namespace freeplay {

/// Lists the mode of every contact and joint with friction in the last step: 0 open, 1 pressed and
/// sticking, 2 and 3 sliding in either direction.
void list_modes(const ContactSet& contacts, const StepProblem& problem, std::vector<signed char>& list);

/// The greatest possible error of a sliding rate (m/s) in the last step, because friction has the
/// direction at the step's end throughout: the rate at the beginning of contacts whose sliding
/// reversed, and the rate that a stopped contact would have gained because friction cannot hold it.
double turned_round(const StepData& step, const ContactSet& contacts, const StepProblem& problem);

/// The greatest rate (m/s) of contacts that are pressed on average over the last step and the one
/// before, with impulses `first`, although by the linear course of the forces they would be in
/// tension at one end.
double lifted(const ContactSet& contacts, const StepProblem& problem, const std::vector<double>& first);

}  // namespace freeplay
