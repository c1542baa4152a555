// Speed against accuracy: every setting on a scene, its errors against a reference of known accuracy and its
// cost. Advice for a user's own scene is study/advice.hpp.
#pragma once

#include <cmath>
#include <nlohmann/json_fwd.hpp>

#include "study/long_run.hpp"

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

nlohmann::json to_json(const TradeoffScene& scene);

}  // namespace freeplay
