// The turns of the measured files that measures of a study compare runs with.
#pragma once

#include <future>
#include <map>
#include <memory>
#include <mutex>
#include <string>

#include "measure/waveform.hpp"
#include "study/runs/case_run.hpp"

namespace freeplay {

/// Cache of measured turns for each file and crank speed. Each file is read once; other threads wait for the result.
/// Safe for concurrent use.
class MeasuredFiles {
 public:
  /// The turns of the measure's file; null if the scene's crank has another speed than the measured
  /// one. `ideal_maximum`: see read_measurement(). Throws SceneError, also if the scene has no crank
  /// of prescribed speed.
  std::shared_ptr<const MeasuredTurns> operator()(const Study& study, const Measure& measure,
                                                  const Scene& scene, double ideal_maximum);

 private:
  using Turns = std::shared_ptr<const MeasuredTurns>;
  std::mutex mutex_;
  std::map<std::pair<std::string, double>, std::shared_future<Turns>> found_;  // by digest and speed
};

}  // namespace freeplay
