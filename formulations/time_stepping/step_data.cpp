#include "formulations/time_stepping/step_data.hpp"

namespace freeplay {

StepData::StepData(const System& system, RowFacts facts)
    : system(system),
      saddle(system.mass(), system.pattern(), SolvePath::automatic, facts,
             system.elastic().pattern.rows > 0 ? &system.elastic().pattern : nullptr),
      elastic(system.elastic().pattern.rows > 0),
      strain_rows(system.elastic().pattern.column.size()),
      compliance(system.elastic().stiffness.size()),
      middle(system.make_evaluation()),
      end(system.make_evaluation()) {
  if (!elastic) saddle.use(system.compiled().solve());
  for (auto* x : {&q, &v, &q_old, &v_old, &q_mid, &v_mean, &force, &dq}) x->resize(system.n());
  for (auto* x : {&z, &z_old, &z_mid}) x->resize(system.states());
  for (auto* x : {&lambda, &r, &dlambda}) x->resize(system.rows());
  totals.extremes.penetration.assign(system.reported(), 0);
}

}  // namespace freeplay
