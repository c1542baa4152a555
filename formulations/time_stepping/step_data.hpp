// What the parts of time stepping read and write of one step: the motion at its beginning, middle and end, the mechanism
// evaluated there, and the sums of the run. Plain data; MoreauStepper owns it and hands it to the parts.
#pragma once

#include <string>
#include <vector>

#include "dynamics/system.hpp"
#include "formulations/time_stepping/step_diagnostics.hpp"
#include "numerics/saddle_point.hpp"
#include "simulation/contact_log.hpp"
#include "values/ledger.hpp"

namespace freeplay {

/// Which contacts may act in a step: all whose gap it would close, by the impact law; or those that are held to be
/// closed alone, without restitution, so that the step is smooth.
enum class StepReach { all, closed };

/// What the steps of a run add up to.
struct RunTotals {
  EnergyLedger integrals;
  Extremes extremes;
  Work work;
  StepDiagnostics found;
};

struct StepData {
  StepData(const System& system, RowFacts facts);

  double length() const { return t - t_old; }
  bool smooth() const { return reach == StepReach::closed; }
  bool fail(std::string why) {
    failure = std::move(why);
    return false;
  }

  const System& system;
  SaddlePoint saddle;                        // factorised at q_mid; by EndRates at q
  Evaluation middle, end;                    // placed at (q_mid, t_old + h/2) and at (q, t)
  std::vector<double> q, v, z;               // at the end; z: first-order states of elements
  std::vector<double> q_old, v_old, z_old;   // at the beginning; z_old where their rates depend on velocities
  std::vector<double> q_mid, v_mean, z_mid;  // at the middle
  std::vector<double> lambda;                // N s, of the constraint rows; after the step over its length
  std::vector<double> force;                 // N s, M v + h f
  std::vector<double> r;                     // right-hand sides of constraint rows
  std::vector<double> dq, dlambda;           // scratch: a movement, and its multipliers
  double t = 0, t_old = 0;                   // s
  StepReach reach = StepReach::all;
  ContactLog* log = nullptr;
  RunTotals totals;
  std::string failure;  // of the last step that failed
};

}  // namespace freeplay
