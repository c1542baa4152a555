// Runs that write a result folder. The files grow while the run steps, a checkpoint beside them
// makes an interrupted run resumable, and the complete files replace those of an earlier run as a
// whole (io/files/result_set.hpp).
//
// run_scene() runs a scene from start to end; resume_run() continues an interrupted run from its
// checkpoint. Both hold the lock of the folder while they write (io/files/folder_lock.hpp) and keep
// no state afterwards.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "io/files/output_estimate.hpp"
#include "mechanism/outside.hpp"
#include "values/compile.hpp"
#include "values/result.hpp"
#include "values/state.hpp"
#include "values/stop.hpp"

namespace freeplay {

struct Scene;

/// Parameters of run_scene(); resume_run() uses some of them.
struct RunPlan {
  std::string formulation = {};  ///< "penalty" or "nonsmooth"
  /// whether contacts of an impact law take the restitution that the scene's penalty law delivers
  bool matched = false;
  std::optional<State> start = {};  ///< as SimulationOptions::start
  /// Code of the caller; a resumed run needs the code it began with.
  Outside outside = {};
  /// Folder of run.json, trajectory.csv, events.csv, signals.csv, forces.csv and pressure.csv. If
  /// absent, nothing is written.
  std::optional<std::filesystem::path> folder = {};
  /// called about 200 times a run with the completed fraction
  std::function<void(double)> on_progress = {};
  StopToken stop = {};
  Compile compile = Compile::automatic;  ///< as SimulationOptions::compile
  /// Wall time between checkpoints, s; 0 disables them. A checkpoint is also written at the start
  /// and at an interruption, and removed when the run ends. A resumed run that is interrupted again
  /// can be resumed in either case.
  double checkpoint = 0;
  /// Whether a time-stepped run is followed by an error estimate of its first contacts
  /// (facade/assess.hpp). Interrupted runs have none.
  bool companion = false;
  std::size_t most_events = 4096;  ///< maximum number of events in Result::events
  /// Limit of the estimated output, bytes: a run whose estimate exceeds it does not begin
  /// (io/files/output_estimate.hpp).
  double most_output = default_output_limit;
  /// number of runs of this size that share the file system, including this one
  int runs_alike = 1;
};

/// Runs a scene from start to end. A finished run in the folder is replaced as a whole when this
/// one has ended; it remains if this one is interrupted or killed. Throws SceneError or
/// OutputError; a numerical failure is reported in Result::ending.
Result run_scene(const Scene& scene, const RunPlan& plan);

/// Whether a folder contains the checkpoint of an unfinished run.
bool has_checkpoint(const std::filesystem::path& folder);

/// Continues the interrupted or killed run of this folder. The files equal those of an
/// uninterrupted run, except for times and memory in run.json. Only progress, stop, checkpoint,
/// companion and outside code are read from `asked`. Throws SnapshotError if there is no checkpoint
/// or this program cannot continue it.
Result resume_run(const std::filesystem::path& folder, const RunPlan& requested);

}  // namespace freeplay
