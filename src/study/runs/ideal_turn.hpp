// Reference motion of the ideal mechanism: one turn of the crank with all clearances closed, as
// seen by the study's instruments. Metrics of runs are related to its greatest acceleration.
#pragma once

#include <string>

#include "study/runs/case_run.hpp"

namespace freeplay {

/// Greatest |a| (m/s²) of the ideal mechanism's turn, computed once for each combination of ideal mechanism,
/// formulation and accelerometer. NaN if the run of the ideal mechanism does not finish. Throws the error of
/// the computation: SceneError, ModelError, Interrupted.
double ideal_maximum(const Study& study, const Scene& scene, const std::string& formulation,
                     const Conduct& conduct);

/// Metrics of the ideal mechanism in one turn, which begins after the first turn when the transient
/// of the accelerometer has decayed.
TurnMetrics ideal_turn(const Study& study, const Scene& scene, const std::string& formulation,
                       const Conduct& conduct);

}  // namespace freeplay
