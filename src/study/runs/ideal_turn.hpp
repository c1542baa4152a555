// The ideal mechanism's turn, which a study's runs are judged by.
#pragma once

#include <future>
#include <map>
#include <mutex>
#include <string>

#include "study/runs/case_run.hpp"

namespace freeplay {

/// The greatest |a| (m/s²) of the ideal turn of each distinct ideal mechanism: what its scene says without play, by one
/// formulation, through one accelerometer. Each is made once, whoever asks; others that ask meanwhile wait for it. NaN where
/// the ideal mechanism cannot be run to the end.
class IdealMaxima {
 public:
  /// Throws what making it throws, to all that ask: SceneError, ModelError, Interrupted.
  double operator()(const Study& study, const Scene& scene, const std::string& formulation,
                    const Conduct& conduct);
  /// How many there are.
  std::size_t made() const;

 private:
  mutable std::mutex mutex_;
  std::map<std::string, std::shared_future<double>> found_;  // by the digest of the identity
};

/// The scene's ideal mechanism through the study's instruments, in the first turn after its first by which the
/// accelerometer has settled, by one formulation.
TurnMetrics ideal_turn(const Study& study, const Scene& scene, const std::string& formulation,
                       const Conduct& conduct);

}  // namespace freeplay
