// Wear of the bearings of a scene, as the table [wear] of a study plans it: cycles of runs and extrapolation
// (wear_cycles.hpp) for each formulation of the study.
//
// Each set of runs has the study's number of starts, which continue the numbers of the set before: chaotic
// motions are thus sampled anew. All starts of a set run in parallel. A run is stored when it ends, by the
// identity of its scene, its worn surfaces and its start, and is not repeated. What is between the runs is
// computed again, with the same digits: an interrupted study ends with the results of an undisturbed one.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "study/ensemble/ensemble.hpp"
#include "study/runs/case_run.hpp"
#include "study/settings/study.hpp"
#include "study/wear/wear_cycles.hpp"

namespace freeplay {

/// Wear of all joints by one formulation.
struct WearHistory {
  std::string formulation;
  std::vector<WearCycle> cycles;  ///< from the unworn state on
  WearEnd end = WearEnd::turns;
  double rounding = 0;  ///< m, greatest change of the surfaces of any run by set_worn()
};

/// Result of a wear study.
struct WearStudy {
  std::vector<WearHistory> histories;  ///< one for each formulation of the study
  double turn = 0;                     ///< s, of a turn
  bool has_period = false;             ///< whether a turn is a period; else it is the evaluated time of a run
  double simulated = 0;                ///< turns of each run
  int starts = 1;                      ///< of each set of runs
  std::vector<double> lengths;         ///< m, bearing_length of each joint
  std::vector<std::string> failures;   ///< of runs, which are left out
  std::size_t found = 0, made = 0;     ///< runs from the store and new ones
  double wall_seconds = 0;             ///< s
  bool interrupted = false;            ///< histories are then not complete
};

/// What it reports at the beginning of a set, after each run, and often while wear is computed.
struct WearProgress {
  std::string formulation;
  double turns = 0, share = 0;     ///< after the last cycle; share: of the way to the nearest limit
  int set = 0;                     ///< number of the last set of runs
  std::size_t done = 0, runs = 0;  ///< of this set: ended runs, and their number
};

/// Throws SceneError if the wear of a study cannot be computed: nothing wears, a limit is reached at the
/// beginning, or its scene cannot be run.
void require_wear(const Study& study, const Conduct& conduct);

/// Computes the wear; runs that the store has are not repeated. A history ends where most runs fail, for the
/// reason in `failures`. Throws SceneError if this is so before the first cycle ends.
WearStudy wear_study(const Study& study, const Conduct& conduct, EnsembleStore& store, int threads,
                     const std::function<void(const WearProgress&)>& on_progress);

/// The joints of a scene that wear, unworn, with surfaces of `points` angles. Throws SceneError if there is none.
std::vector<WornBearing> wearing_joints(const Scene& scene, std::size_t points);

/// The loads of a run as numbers of a row of its store, and back; the number of joints is that of the names.
std::vector<double> packed(const std::vector<BearingLoads>& loads);
/// Throws SceneError for a row that is damaged.
std::vector<BearingLoads> unpacked(const std::vector<double>& row, const std::vector<std::string>& joints);

}  // namespace freeplay
