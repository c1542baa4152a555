// One scene in both formulations, side by side. The impact law takes the restitution that the penalty law
// delivers unless asked not to. Single impacts are compared up to a horizon, statistics over the whole run.
//
// Pairing: the i-th touches of a joint belong together while their times differ by less than a quarter of the
// time since the joint's previous touch and their approach speeds by less than a factor of two. The first
// touch that breaks this rule in any joint ends the horizon: beyond it the motions have parted and single
// events mean nothing.
#pragma once

#include <cmath>
#include <filesystem>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "sim/stop.hpp"
#include "values/result.hpp"

namespace freeplay {

struct Scene;

struct ImpactPair {
  ContactEvent penalty, nonsmooth;
};

struct Pairing {
  std::vector<ImpactPair> pairs;  ///< in the order of time
  double horizon = 0;             ///< s, of the last pair
  std::string ended_by;           ///< why it ends there
};

/// Pairs the touches (impacts and beginnings of lasting contact) of two runs.
/// `until`: s, to which each list is known whole: a cut list is known to its last event.
Pairing pair_impacts(const std::vector<ContactEvent>& penalty, const std::vector<ContactEvent>& nonsmooth,
                     int joints, double until = INFINITY);

struct Comparison {
  bool matched = true;  ///< the impact law took the delivered values
  Result penalty, nonsmooth;
  std::optional<Result> ideal;  ///< all clearances closed; absent when the scene has none
  Pairing pairing;
  std::vector<std::string> joints;
};

struct CompareSetup {
  bool matched = true;  ///< the impact law takes the delivered values
  StopToken stop;
  std::function<void(const std::string&, double)> on_progress;  ///< (which run, fraction done)
};

/// Runs a scene in both formulations into folder/penalty, folder/nonsmooth and folder/ideal, and writes
/// comparison.json and comparison.md. Throws SceneError or OutputError.
Comparison compare(const Scene& scene, const CompareSetup& setup, const std::filesystem::path& folder);

/// The tables as text of at most 80 columns, and the same as Markdown.
std::string comparison_table(const Scene& scene, const Comparison& comparison, bool markdown);
nlohmann::json to_json(const Comparison& comparison);

}  // namespace freeplay
