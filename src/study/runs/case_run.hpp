// One run of a study (a case): its scene, its key in the database, and its execution in memory.
// cases() lists the runs of a study; run_case() assembles the perturbed start, runs the scene, and
// evaluates the metrics of its turns and the measures of the study. Results depend on the case
// only, not on other runs or threads.
#pragma once

#include <filesystem>
#include <future>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "measure/turns.hpp"
#include "measure/waveform.hpp"
#include "study/runs/executor.hpp"
#include "study/runs/measurer.hpp"
#include "study/settings/study.hpp"
#include "values/identity.hpp"
#include "values/result.hpp"
#include "values/stop.hpp"

namespace freeplay {

// Intermediate results that the runs of a study share: of ideal mechanisms and of measured files. Each is
// computed once; other threads wait for it.

/// Results by their keys. Safe for concurrent use.
template <class Key, class Value>
class ComputedOnce {
 public:
  /// The result for this key: computes it, waits for the thread that does, or returns it. Throws the error of
  /// the computation.
  template <class F>
  Value operator()(const Key& key, F&& compute) {
    std::promise<Value> made;
    std::shared_future<Value> found;
    bool mine = false;
    {
      const std::lock_guard lock(mutex_);
      auto& entry = found_[key];
      mine = !entry.valid();
      if (mine) entry = made.get_future().share();
      found = entry;
    }
    if (mine) try {
        made.set_value(compute());
      } catch (...) {
        made.set_exception(std::current_exception());
      }
    return found.get();
  }

 private:
  std::mutex mutex_;
  std::map<Key, std::shared_future<Value>> found_;
};

/// Keys are digests of identities, and of a file with the speed of its crank (rad/s).
struct SharedResults {
  ComputedOnce<std::string, double> ideal_maxima;        ///< study/runs/turns.hpp
  ComputedOnce<std::string, std::vector<double>> poses;  ///< study/runs/perturb.hpp
  ComputedOnce<std::pair<std::string, double>, std::shared_ptr<const MeasuredTurns>> files;
};

struct Scene;
class SceneText;

/// Specification of one run.
struct Case {
  std::string variant, formulation;
  std::vector<double> values;  ///< of the study's axes
  int start = 0;
  double revolutions = 0;
  std::filesystem::path scene;
  std::vector<std::string> overrides;  ///< of the variant and the axes
  /// Hz, sampling rate at which the acceleration is evaluated; 0: the instrument's own.
  double sampling = 0;
  double noise = 0;  ///< m/s², standard deviation of additional white noise
  /// Of the scene with the first of these overrides; null: the file is read.
  std::shared_ptr<const SceneText> text = {};
};

/// Result of one run.
struct CaseResult {
  Ending ending;
  TurnMetrics metrics;
  std::vector<std::string> contacts;   ///< names of the contacts of flights and impacts
  std::vector<MeasureValue> measured;  ///< values of the study's measures
  Work work;
  double cpu_seconds = 0;
  std::vector<std::string> notes;
};

/// Options for the runs of a study, and results that they share.
struct Conduct {
  /// Whether impact laws take the delivered restitution if the study requests it.
  bool matched = true;
  StopToken stop = {};
  std::shared_ptr<SharedResults> shared =
      std::make_shared<SharedResults>();  ///< by all copies of this object
};

/// All cases of a study: variants × cells × formulations × starts. If a scene has no property in
/// which starts could differ, and the study does not request several starts, plan() takes the first
/// only.
std::vector<Case> cases(const Study& study);

/// The scene of a case with its perturbed start.
Scene scene_of(const Study& study, const Case& one, const Conduct& conduct);

/// The time that is evaluated in a case's run of this scene, as the study states it.
CountedTime counted_time(const Study& study, const Scene& scene);
/// Whether the starts of the case differ.
bool has_starts(const Study& study, const Case& one);

/// Throws SceneError if a study cannot be compared with a measured signal: it names no
/// accelerometer or not exactly one joint, or its scene has no drive with prescribed speed. `by`:
/// the comparison, for the message.
void require_signal(const Study& study, const char* by);

/// A case that is ready to start: first the discarded time, then the evaluated one. Refers to the study
/// and the case. The constructor throws SceneError.
class CaseRun : public StudyRun {
 public:
  /// `compilation`: of its study; null: it is alone.
  CaseRun(const Study& study, const Case& one, const Conduct& conduct,
          SharedCompilation* compilation = nullptr);
  ~CaseRun() override;
  Simulation& simulation() override;
  RunRequest request() override;
  double next_shown() const override;
  std::vector<Observer*> followers() const override;
  bool take(Result run) override;
  /// The result after its end.
  CaseResult& made();

 private:
  struct Parts;
  std::unique_ptr<Parts> it_;
};

/// Runs a case. Throws SceneError; a numerical failure is in CaseResult::ending.
CaseResult run_case(const Study& study, const Case& one, const Conduct& conduct);

/// Identity that all starts of a case share: the scene without its start, the settings of the
/// study, and the case's row of results. Throws SceneError.
Identity identity(const Study& study, const Case& one, const Conduct& conduct);
/// A case that can be run.
struct RunnableCase {
  Identity all_starts;
  bool starts_differ = false;
};
/// Throws SceneError if a case cannot be run: its scene is invalid, cannot be assembled by its
/// formulation, or lacks something that the study names.
RunnableCase require_runnable(const Study& study, const Case& one, const Conduct& conduct);

}  // namespace freeplay
