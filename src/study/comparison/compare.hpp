// Comparison of both formulations on one scene (`freeplay compare`). By default the impact law
// takes the restitution that the penalty law delivers. Single impacts are compared up to a horizon,
// statistics over the whole run.
//
// Pairing: the i-th onsets of a contact in the two runs correspond while
//
//     |Δt| ≤ ¼ F,   |Δt| ≤ 1/36 of a turn,   |Δt| ≤ 10 (S + R F + u),   ½ < v/v' < 2,
//
// where F is the shorter of the flights before them, since the last separation or the start; S the
// greatest time difference of earlier pairs, including durations of impacts; R the greatest
// relative difference of their speeds (at least 1e-3); and u the uncertainty of both times. An
// impact corresponds to the beginning of a lasting contact if that lasts less than F/4. A contact
// that is closed at the start has no onset. The first onset in any contact that violates this rule
// ends the horizon: beyond it the motions have diverged, and single events are not comparable.
//
// Onsets that one run resolves and the other does not are merged: an onset that falls within the
// contact of the other run belongs to the same pair, if the flight before it is not longer than the
// longest impact T of the penalty run in this contact. A sequence of such onsets counts as one contact
// up to its end, and corresponds to a lasting contact that ends within T or within a factor of two.
//
// Loads: an impact of the penalty run lasts, and its impulse contains that of the load. With g̈₀ the
// acceleration of the gap without the contact force, and m the effective mass,
//
//     P = m (v⁺ − v⁻) + ∫ (−m g̈₀) dt,
//
// where −m g̈₀ is the force of a lasting contact. The first part is the impulse of the impact. m follows
// from the impact of the nonsmooth run in the pair, m = P/(v⁺ − v⁻), if it is the only one at its instant.
#pragma once

#include <cmath>
#include <filesystem>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "io/files/output_estimate.hpp"
#include "study/verdicts/verdicts.hpp"
#include "values/result.hpp"
#include "values/stop.hpp"

namespace freeplay {

struct Scene;

/// Corresponding contact onsets of the two formulations.
struct ImpactPair {
  ContactEvent penalty, nonsmooth;
  int merged_penalty = 0, merged_nonsmooth = 0;  ///< further onsets of the same contact
  /// N s, part of the load in the penalty run's impulse; NaN: unknown.
  double load = NAN;
  /// N s, penalty run's impulse without the load, if that is known.
  double impulse() const { return penalty.impulse_n - (std::isnan(load) ? 0 : load); }
  /// Whether the load exceeds the impact: the impulses cannot be compared.
  bool loaded() const { return std::abs(load) > std::abs(impulse()); }
};

/// Result of the pairing.
struct Pairing {
  std::vector<ImpactPair> pairs;  ///< in the order of time
  double horizon = 0;             ///< s, time of the last pair
  bool complete = false;          ///< whether all contact onsets of both runs are paired
  bool cut = false;               ///< whether it ends where the list of a run's events is truncated
  std::string ended_by;           ///< reason for the end of the horizon
  /// Whether it ends within an impact of the penalty run at another contact: the nonsmooth run has impacts
  /// in sequence there, so that events are not comparable one by one.
  bool overlapping = false;
};

/// Pairs the contact onsets (impacts and beginnings of lasting contact) of two runs. `until`: s,
/// time up to which each list is complete; for a truncated list that of its last event. `turn`: s,
/// period of the drive; infinite without a drive of prescribed speed. `names`: of the contacts, for
/// messages.
Pairing pair_impacts(const std::vector<ContactEvent>& penalty, const std::vector<ContactEvent>& nonsmooth,
                     int joints, double until = INFINITY, double turn = INFINITY,
                     const std::vector<std::string>& names = {});

/// The horizon that the growth of differences predicts (predicted_horizon.hpp).
struct PredictedHorizon {
  double t = NAN;           ///< s, time of the last pair; NaN without a prediction
  bool to_the_end = false;  ///< whether all contact onsets would be paired
  std::string reason;       ///< why there is no prediction; empty if there is one
};

/// Results of both formulations.
struct Comparison {
  bool matched = true;  ///< whether the impact law took the delivered values
  /// For each contact the properties in which the two laws differ although they should agree;
  /// empty: matched.
  std::vector<std::vector<std::string>> not_matched;
  /// Whether the contact has friction; the friction laws of the two always differ.
  std::vector<bool> frictional;
  Result penalty, nonsmooth;
  std::optional<Result> ideal;  ///< with all clearances closed; absent if the scene has none
  Pairing pairing;
  PredictedHorizon predicted;
  std::vector<std::string> joints;
  std::string verdict;  ///< conclusion in words
};

/// Options of compare().
struct CompareSetup {
  bool matched = true;  ///< whether the impact law takes the delivered values
  StopToken stop = {};
  /// Bytes, of all runs together, as RunPlan::most_output.
  double most_output = default_output_limit;
  /// Receives the name of the run and the completed fraction.
  std::function<void(const std::string&, double)> on_progress = {};
};

/// Runs a scene in both formulations into folder/penalty, folder/nonsmooth and folder/ideal, and
/// writes comparison.json and comparison.md. Throws SceneError or OutputError.
Comparison compare(const Scene& scene, const CompareSetup& setup, const std::filesystem::path& folder);

/// The tables as text of at most 80 columns with sentences of any length, or as Markdown.
std::string comparison_table(const Scene& scene, const Comparison& comparison, bool markdown);
/// The values from which the verdict follows.
ComparisonValues comparison_values(const Scene& scene, const Comparison& comparison);
/// The contents of comparison.json, without provenance.
nlohmann::json to_json(const Comparison& comparison);

}  // namespace freeplay
