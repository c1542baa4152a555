// Reference motion of the ideal mechanism: one turn of the crank with all clearances closed, as
// seen by the study's instruments. Metrics of runs are related to its greatest acceleration.
#pragma once

#include <future>
#include <map>
#include <mutex>
#include <string>

#include "study/runs/case_run.hpp"

namespace freeplay {

/// Cache of the greatest |a| (m/s²) of the ideal mechanism's turn, for each combination of ideal
/// mechanism, formulation and accelerometer. Each is computed once; other threads wait for the
/// result. NaN if the run of the ideal mechanism does not finish. Safe for concurrent use.
class IdealMaxima {
 public:
  /// The value for this scene. Throws the error of the computation: SceneError, ModelError,
  /// Interrupted.
  double operator()(const Study& study, const Scene& scene, const std::string& formulation,
                    const Conduct& conduct);
  /// Number of stored values.
  std::size_t made() const;

 private:
  mutable std::mutex mutex_;
  std::map<std::string, std::shared_future<double>> found_;  // by the digest of the identity
};

/// Metrics of the ideal mechanism in one turn, which begins after the first turn when the transient
/// of the accelerometer has decayed.
TurnMetrics ideal_turn(const Study& study, const Scene& scene, const std::string& formulation,
                       const Conduct& conduct);

}  // namespace freeplay
