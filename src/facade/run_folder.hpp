// A run with its result folder: files streamed while it steps, a checkpoint beside them, the rest of an interrupted
// run made later.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "io/files/output_estimate.hpp"
#include "mechanism/outside.hpp"
#include "values/result.hpp"
#include "values/state.hpp"
#include "values/stop.hpp"

namespace freeplay {

struct Scene;

struct RunPlan {
  std::string formulation = {};  ///< "penalty" or "nonsmooth"
  bool matched = false;  ///< an impact law takes the restitution that the scene's penalty law delivers
  std::optional<State> start = {};  ///< as SimulationOptions::start
  Outside outside = {};             ///< of a run that is gone on with: what it was begun with
  /// Where run.json, trajectory.csv, events.csv, signals.csv and forces.csv go; without one nothing is written.
  std::optional<std::filesystem::path> folder = {};
  std::function<void(double)> on_progress = {};  ///< now and then, with the fraction done
  StopToken stop = {};
  /// s of wall time between checkpoints; 0: none. One is written at the start and when the run is
  /// interrupted, and removed when it ends. A run that is resumed and interrupted again can be resumed again
  /// either way.
  double checkpoint = 0;
  /// After a time-stepped run, a companion at a shorter step says how far the first touches may be off
  /// (facade/companion.hpp). Not of interrupted runs.
  bool companion = false;
  std::size_t most_events = 4096;  ///< kept in Result::events
  /// bytes: a run whose files are estimated to be greater is not begun (io/files/output_estimate.hpp).
  double most_output = default_output_limit;
  int runs_alike = 1;  ///< to be written there, this one counted
};

/// One run from start to end. A finished run that stands in the folder is replaced as a whole when this one has ended, and
/// stays when this one is interrupted or killed. Throws SceneError or OutputError; a numerical failure is in the result's ending.
Result run_scene(const Scene& scene, const RunPlan& plan);

/// Whether a folder holds the checkpoint of a run that has not ended.
bool has_checkpoint(const std::filesystem::path& folder);

/// Goes on with the run that was interrupted or killed in this folder: the same files as if it had not been, but for
/// times and memory in run.json. Of `asked` progress, stop, checkpoint and companion are taken. Throws SnapshotError when there
/// is nothing to go on with, or this program cannot.
Result resume_run(const std::filesystem::path& folder, const RunPlan& asked);

}  // namespace freeplay
