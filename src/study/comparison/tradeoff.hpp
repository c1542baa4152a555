// Speed against accuracy: cost and errors of all settings on a scene, relative to a reference of
// known accuracy (`freeplay tradeoff`). study/comparison/advice.hpp selects a setting for a user's
// scene.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include <cmath>
#include <filesystem>

#include "study/comparison/settings.hpp"
#include "values/table.hpp"

namespace freeplay {

/// Measurements on one scene.
struct TradeoffScene {
  std::string name, title;
  std::string variant;         ///< title of the variant in the study
  std::filesystem::path file;  ///< of its scene
  Reference penalty, nonsmooth;
  /// Modelling error of the penalty formulation: the first two contact onsets of its reference
  /// against those of the impact law with the delivered restitution. It is caused by the finite
  /// stiffness K, not by the numerics. NaN without contact onsets.
  double model_error = 0;
  /// Relative standard deviation of the dissipated energy over perturbed starts.
  double sampling_error = NAN;
  std::vector<Measured> measured;

  const Reference& reference(Family family) const { return family == Family::penalty ? penalty : nonsmooth; }
};

/// Runs each setting `repeats` times, interleaved, then the long runs for statistics.
TradeoffScene trade_off(const Scene& scene, const Conduct& conduct, int repeats, const Sampling& sampling,
                        const std::function<void(double)>& on_progress);

/// Methods of the scene and their orders in work: the slope of −log error over log right-hand
/// sides, by least squares over the settings whose error lies between twice the accuracy of the
/// reference and 0.5. The error is that of contact events, or of the state if there are none.
/// Excludes methods with fewer than three such settings, and those whose errors do not follow a
/// line (correlation of the logarithms below 0.9).
std::vector<std::pair<std::string, double>> orders_in_work(const TradeoffScene& t);

/// tradeoff.json, without provenance.
nlohmann::json to_json(const std::vector<TradeoffScene>& scenes);
/// The results of one scene for a terminal.
std::string tradeoff_text(const TradeoffScene& t);
/// tradeoff.csv.
Table tradeoff_table(const std::vector<TradeoffScene>& scenes);
/// The page tradeoff.md. `figures`: files in its folder figures; `first` of them is shown on top.
std::string tradeoff_page(const std::vector<TradeoffScene>& scenes, std::vector<std::string> figures,
                          const std::string& first, const std::string& command, int repeats);

}  // namespace freeplay
