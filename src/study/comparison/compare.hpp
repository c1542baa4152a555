// One scene in both formulations, side by side. The impact law takes the restitution that the penalty law
// delivers unless asked not to. Single impacts are compared up to a horizon, statistics over the whole run.
//
// Pairing: the i-th touches of a contact belong together while
//
//     |Δt| ≤ ¼ F,   |Δt| ≤ a 36th of a turn,   |Δt| ≤ 10 (S + R F + u),   ½ < v/v' < 2,
//
// F being the shorter of the flights before them, since the contact was last lost or the start; S the greatest
// difference of times among the pairs before, durations of the impacts included; R the greatest relative difference of
// their speeds (at least 1e-3); u the uncertainty of both times. An impact and the beginning of a lasting contact belong
// together when that lasts less than F/4. A contact that rests at the start is no touch. The first touch that breaks
// this rule in any contact ends the horizon: beyond it the motions have parted and single events mean nothing.
#pragma once

#include <cmath>
#include <filesystem>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "io/files/output_estimate.hpp"
#include "values/result.hpp"
#include "values/stop.hpp"

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
/// `turn`: s, period of the drive; infinite where nothing turns at a prescribed speed.
/// `names`: of the contacts, to say which touch has no partner.
Pairing pair_impacts(const std::vector<ContactEvent>& penalty, const std::vector<ContactEvent>& nonsmooth,
                     int joints, double until = INFINITY, double turn = INFINITY,
                     const std::vector<std::string>& names = {});

struct Comparison {
  bool matched = true;  ///< the impact law took the delivered values
  /// Of each contact what the two laws do not have in common though it was asked of both; empty: matched.
  std::vector<std::vector<std::string>> not_matched;
  std::vector<bool> frictional;  ///< of each contact, whether it has friction, whose laws are never the same
  Result penalty, nonsmooth;
  std::optional<Result> ideal;  ///< all clearances closed; absent when the scene has none
  Pairing pairing;
  std::vector<std::string> joints;
};

struct CompareSetup {
  bool matched = true;  ///< the impact law takes the delivered values
  StopToken stop = {};
  double most_output = default_output_limit;  ///< bytes, of all runs together, as RunPlan::most_output
  std::function<void(const std::string&, double)> on_progress = {};  ///< (which run, fraction done)
};

/// Runs a scene in both formulations into folder/penalty, folder/nonsmooth and folder/ideal, and writes
/// comparison.json and comparison.md. Throws SceneError or OutputError.
Comparison compare(const Scene& scene, const CompareSetup& setup, const std::filesystem::path& folder);

/// The tables as text of at most 80 columns, and the same as Markdown.
std::string comparison_table(const Scene& scene, const Comparison& comparison, bool markdown);
nlohmann::json to_json(const Comparison& comparison);

}  // namespace freeplay
