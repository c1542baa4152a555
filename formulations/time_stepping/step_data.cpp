#include "formulations/time_stepping/step_data.hpp"

namespace freeplay {

StepData::StepData(const System& system, RowFacts facts)
    : system(system),
      saddle(system.mass(), system.pattern(), SolvePath::automatic, facts),
      middle(system.make_evaluation()),
      end(system.make_evaluation()) {
  saddle.use(system.compiled().solve());
  for (auto* x : {&q, &v, &q_old, &v_old, &q_mid, &v_mean, &force, &dq}) x->resize(system.n());
  for (auto* x : {&z, &z_old, &z_mid}) x->resize(system.states());
  for (auto* x : {&lambda, &r, &dlambda}) x->resize(system.rows());
  totals.extremes.penetration.assign(system.reported(), 0);
}

}  // namespace freeplay
