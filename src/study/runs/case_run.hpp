// One run of a study, in memory.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "measure/turns.hpp"
#include "study/runs/measurer.hpp"
#include "study/settings/study.hpp"
#include "values/identity.hpp"
#include "values/result.hpp"
#include "values/stop.hpp"

namespace freeplay {

struct Scene;
class IdealMaxima;
class NearPoses;

/// One run of a study.
struct Case {
  std::string variant, formulation;
  std::vector<double> values;  ///< of the study's axes
  int start = 0;
  double revolutions = 0;
  std::filesystem::path scene;
  std::vector<std::string> overrides;  ///< of the variant and the axes
  double sampling = 0;                 ///< Hz, that the accelerometer's signal is judged at; 0: its own
  double noise = 0;                    ///< m/s², standard, white, that it bears besides
};

struct CaseResult {
  Ending ending;
  TurnMetrics metrics;
  std::vector<std::string> contacts;   ///< names, of flights and impacts
  std::vector<MeasureValue> measured;  ///< of the study's measures
  Work work;
  double cpu_seconds = 0;
  std::vector<std::string> notes;
};

/// How a study's runs are conducted.
struct Conduct {
  bool matched = true;  ///< where a study asks for it, impact laws take the delivered restitution
  StopToken stop;
  /// What is known of ideal mechanisms; all runs of one conduct share it.
  std::shared_ptr<IdealMaxima> ideals = known_of_none();

  std::shared_ptr<NearPoses> poses = near_none();

  static std::shared_ptr<IdealMaxima> known_of_none();
  static std::shared_ptr<NearPoses> near_none();
};

/// Every case of a study: variants × cells × formulations × starts. Where a scene has nothing that starts could differ in and
/// the study does not ask for several, plan() takes the first alone.
std::vector<Case> cases(const Study& study);

/// The scene of a case, read and ready to run from its perturbed start.
Scene scene_of(const Study& study, const Case& one, const Conduct& conduct);

/// What is counted of a case's run of this scene, which is as long as the study asks.
CountedTime counted_time(const Study& study, const Scene& scene);
/// Whether starts of the case differ.
bool has_starts(const Study& study, const Case& one);

/// Throws SceneError where a study cannot be judged by a measured signal: it names no accelerometer or no single joint, or
/// its scene has no drive of prescribed speed. `by`: what judges it.
void require_signal(const Study& study, const char* by);

/// Throws SceneError when a case cannot be run: its scene is refused, cannot be assembled by its formulation, or has not
/// what the study names.
void require_runnable(const Study& study, const Case& one, const Conduct& conduct);
/// Runs it. Throws SceneError; a numerical failure is in the ending.
CaseResult run_case(const Study& study, const Case& one, const Conduct& conduct);

/// What all starts of a case have in common: the scene as it will run, but for where it starts; the study's settings;
/// and which row of the results it is. Throws SceneError.
Identity identity(const Study& study, const Case& one, const Conduct& conduct);
/// The name that one of them is stored by; equal names, equal bits.
std::string run_key(Identity all_starts, int start);

}  // namespace freeplay
