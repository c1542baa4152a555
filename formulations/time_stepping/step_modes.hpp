// What contacts and joints with friction did in the last step, and what its impulses cannot tell of the motion within it: both are
// what a control of steps judges a step by.
#pragma once

#include <vector>

#include "formulations/time_stepping/step_problem.hpp"

namespace freeplay {

/// Of every contact and joint with friction in the last step: 0 open, 1 pressed and sticking, 2 and 3 sliding either way.
void list_modes(const ContactSet& contacts, const StepProblem& problem, std::vector<signed char>& list);

/// The greatest sliding rate (m/s) that the last step may have wrong as friction had the direction of its end all along:
/// that at its beginning of what slides the other way at its end; what the step would have given to what it stopped and
/// friction cannot hold.
double turned_round(const StepData& step, const ContactSet& contacts, const StepProblem& problem);

/// What is pressed on the whole of the last step and of the one before, with impulses `first`, but by the forces' own course
/// would have pulled at an end of the two: the rate (m/s) that it took for it.
double lifted(const ContactSet& contacts, const StepProblem& problem, const std::vector<double>& first);

}  // namespace freeplay
