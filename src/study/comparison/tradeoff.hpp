// Speed against accuracy: every setting on a scene, its errors against a reference of known accuracy and its
// cost. Advice for a user's own scene is study/comparison/advice.hpp.
#pragma once

#include <cmath>
#include <nlohmann/json_fwd.hpp>

#include "study/runs/long_run.hpp"

namespace freeplay {

struct TradeoffScene {
  std::string name, title;
  Reference penalty, nonsmooth;
  /// Of penalty's model: its reference's first two touches against the impact law's at the delivered
  /// restitution. Finite K, not numerics. NaN without touches.
  double model_error = 0;
  double sampling_error = NAN;  ///< relative standard deviation of the energy lost over perturbed starts
  std::vector<Measured> measured;

  const Reference& reference(Family family) const { return family == Family::penalty ? penalty : nonsmooth; }
};

/// Each setting `repeats` times, interleaved; then long runs.
TradeoffScene trade_off(const Scene& scene, const Conduct& conduct, int repeats, const Sampling& sampling,
                        const std::function<void(double)>& on_progress);

/// A method of the scene and its order in work: the slope of −log error over log right-hand sides, least squares over its
/// settings whose error lies between twice what the reference is known to and 0.5. The error is that of events, or of the
/// state where there are no touches to judge by. Left out are methods with fewer than three such settings, and those whose errors
/// do not fall along a line (correlation of the logarithms below 0.9).
std::vector<std::pair<std::string, double>> orders_in_work(const TradeoffScene& t);

nlohmann::json to_json(const TradeoffScene& t);

}  // namespace freeplay
