// StepData: data of one step that the parts of time stepping read and write: the motion at its
// beginning, middle and end, the mechanism evaluated there, and the totals of the run. Plain data;
// MoreauStepper owns it and passes it to the parts.
#pragma once

#include <string>
#include <vector>

#include "dynamics/system.hpp"
#include "formulations/time_stepping/step_diagnostics.hpp"
#include "formulations/time_stepping/step_kernel.hpp"
#include "numerics/saddle_point.hpp"
#include "simulation/contact_log.hpp"
#include "values/ledger.hpp"

namespace freeplay {

/// Which contacts may act in a step: all contacts whose gaps it would close, by the impact law; or
/// only contacts marked as closed, without restitution, so that the step is smooth.
enum class StepReach { all, closed };

/// The ends of a step.
struct StepEnds {
  const double *q_old, *q, *v_old, *v;
};
/// The state at a time t within the step from t_old to t_new, of n coordinates.
inline void interpolate_step(double t_old, double t_new, double t, const StepEnds& d, int n, double* q,
                             double* v) {
  const double s = t_new > t_old ? (t - t_old) / (t_new - t_old) : 1;
  for (int i = 0; i < n; ++i) {
    q[i] = d.q_old[i] + s * (d.q[i] - d.q_old[i]);
    v[i] = d.v_old[i] + s * (d.v[i] - d.v_old[i]);
  }
}

/// Totals over the steps of a run.
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
  SaddlePoint saddle;                           // factorised at q_mid; by EndRates at q
  bool elastic;                                 // whether there are elastic rows
  std::vector<double> strain_rows, compliance;  // B at q_mid and Σ, of System::elastic()
  Evaluation middle, end;                       // evaluated at (q_mid, t_old + h/2) and at (q, t)
  std::vector<double> q, v, z;                  // at the end; z: first-order states of elements
  // at the beginning; z_old if rates of z depend on velocities
  std::vector<double> q_old, v_old, z_old;
  std::vector<double> q_mid, v_mean, z_mid;  // at the middle
  // N s, of the constraint rows; N after the step (divided by its length)
  std::vector<double> lambda;
  std::vector<double> force;        // N s, M v + h f; with elastic rows without M v
  std::vector<double> r;            // right-hand sides of constraint rows; then without G v
  std::vector<double> dq, dlambda;  // work space: a displacement and its multipliers
  double t = 0, t_old = 0;          // s
  StepReach reach = StepReach::all;
  StepKernel kernel;
  bool whole = false;  // the kernel has evaluated the middle of this step, and will do its end
  ContactLog* log = nullptr;
  RunTotals totals;
  std::string failure;  // reason of the last failed step
};

}  // namespace freeplay
