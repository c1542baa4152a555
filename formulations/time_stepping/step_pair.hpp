// StepPair: one step of h and two steps of h/2 from the same state, with closed contacts only.
// Their difference is three times the error of the two half steps, which is accepted up to
// nonsmooth.step_tolerance in the norm of the event-driven scheme's integrator. If the contacts
// have the same modes in all three steps, the result is extrapolated. Otherwise the difference
// itself is the error estimate.
#pragma once

#include <array>
#include <cmath>
#include <vector>

#include "formulations/integrators/tolerance.hpp"
#include "formulations/time_stepping/moreau.hpp"
#include "formulations/time_stepping/step_problem.hpp"

namespace freeplay {

// Modes of contacts and joints with friction in the last step, and errors within a step that its
// impulses do not show. Adaptive time stepping uses both to estimate the error of a step.

/// Lists the mode of every contact and joint with friction in the last step: 0 open, 1 pressed and
/// sticking, 2 and 3 sliding in either direction.
void list_modes(const ContactSet& contacts, const StepProblem& problem, std::vector<signed char>& list);

/// The greatest possible error of a sliding rate (m/s) in the last step, because friction has the
/// direction at the step's end throughout: the rate at the beginning of contacts whose sliding
/// reversed, and the rate that a stopped contact would have gained because friction cannot hold it.
double slip_reversal_error(const StepData& step, const ContactSet& contacts, const StepProblem& problem);

/// What all forces but its own give a closed contact in one step.
struct Pull {
  double rate = 0;  ///< m/s, gained by the gap; < 0 presses the contact, whose impulse takes it
  bool pressed = false;
};
/// Lists the pulls of the last step; 0 of contacts that are not closed.
void list_pulls(const StepData& step, const ContactSet& contacts, const StepProblem& problem,
                std::vector<Pull>& list);

/// How far the impulse of friction is beyond its bounds in one step, as rates (m/s): in the positive and in the
/// negative direction. Both are < 0 where friction holds.
struct Hold {
  std::array<double, 2> beyond{};
  bool held = false;
};
/// Lists the holds of all contacts and joints with friction in the last step.
void list_holds(const StepData& step, const ContactSet& contacts, const StepProblem& problem,
                std::vector<Hold>& list);

/// Quantities of one step.
struct StepView {
  std::vector<signed char> modes;
  std::vector<Pull> pulls;
  std::vector<Hold> holds;
};

/// Changes of closed contacts and of friction within a step and its two halves, by the parabolas through their
/// pulls and holds.
struct MissedChanges {
  /// m/s, the greatest rate that the halves miss: a contact is pressed, or released, in a part of a half that
  /// takes it as released, or as pressed, throughout; or friction that all three hold has to slip in a part
  double rate = 0;
  double first = INFINITY;  ///< the first separation or slip, as a share of the step
};
MissedChanges missed_changes(const StepView& whole, const StepView& first, const StepView& second);

class StepPair {
 public:
  StepPair(const System& system, const ErrorNorm& norm, double speed_scale);

  /// Takes the steps from `start`, the present state of the stepper, which ends at the end of the
  /// half steps. Returns false if one failed.
  bool take(MoreauStepper& moreau, double h);
  /// Whether the modes are the same in all three steps and no sliding reversed within one.
  bool alike() const {
    return view_whole_.modes == view_first_.modes && view_first_.modes == view_second_.modes &&
           slip_reversal_ == 0;
  }
  /// Error estimate over the accepted error.
  double error(const MoreauStepper& moreau) const;
  void extrapolate(MoreauStepper& moreau);
  /// The first separation of a contact or slip of friction, as a share of the step; infinite if there is none,
  /// or if the step misses less than a thousandth of the accepted error with it.
  double first_change() const { return unseen(missed_.rate) > 1e-3 ? missed_.first : INFINITY; }

  /// @name Forces of the pair
  ///@{
  void watch_forces(bool on);
  bool watching() const { return watching_; }
  /// Takes the forces of a single step instead.
  void take_forces(const MoreauStepper& moreau);
  Forces smooth, within;
  /// Modes at a time within the pair, as list_modes() lists them.
  const std::vector<signed char>& modes(double t) const {
    return t < middle_t ? view_first_.modes : view_second_.modes;
  }
  ///@}

  /// @name The path: Hermite cubics through three states
  ///@{
  MoreauStepper::Place start;
  std::vector<double> middle_q, middle_v;
  double middle_t = 0;  // s
  void interpolate(const MoreauStepper& moreau, double t, double* q, double* v) const;
  ///@}

 private:
  double difference(const MoreauStepper& moreau) const;
  double path_error(const MoreauStepper& moreau) const;
  double unseen(double rate) const;

  const System& system_;
  ErrorNorm norm_;
  double speed_scale_;  // m/s
  MoreauStepper::Place whole_;
  StepView view_whole_, view_first_, view_second_;
  double slip_reversal_ = 0;  // m/s; see slip_reversal_error()
  MissedChanges missed_;
  bool watching_ = false;
  Forces whole_smooth_;
};

}  // namespace freeplay
