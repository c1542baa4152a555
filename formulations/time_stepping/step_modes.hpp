// Modes of contacts and joints with friction in the last step, and errors within a step that its
// impulses do not show. Adaptive time stepping uses both to estimate the error of a step.
#pragma once

#include <cmath>
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

/// What all forces but its own give a closed contact in one step.
struct Pull {
  double rate = 0;  ///< m/s, gained by the gap; < 0 presses the contact, whose impulse takes it
  bool pressed = false;
};
/// Lists the pulls of the last step; 0 of contacts that are not closed.
void list_pulls(const StepData& step, const ContactSet& contacts, const StepProblem& problem,
                std::vector<Pull>& list);

/// Changes of closed contacts within a step and its two halves, by the parabola through their pulls.
struct Misjudged {
  /// m/s, the greatest rate that the halves miss: a contact is pressed, or released, in a part of a
  /// half that takes it as released, or as pressed, throughout
  double rate = 0;
  double separation = INFINITY;  ///< the first one, as a share of the step
};
Misjudged misjudged(const std::vector<Pull>& whole, const std::vector<Pull>& first,
                    const std::vector<Pull>& second);

}  // namespace freeplay
