// Execution of runs that determine attractors. Runs that are stored
// (study/attractors/attractor_store.hpp) are not repeated.
//
// A chain is a sequence of runs, each of which may start where the one before ended. The positions
// and velocities of the bodies are projected onto the constraints of the next value
// (dynamics/assembly/assembly.hpp); first-order states are kept. Contacts start anew. Drives
// continue from their angles; quantities prescribed by a curve continue because a run ends after
// whole periods.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "study/attractors/attractor_store.hpp"
#include "study/settings/study.hpp"

namespace freeplay {

struct Scene;

/// One run: its scene, and its row in the results.
struct ChainLink {
  std::vector<std::string> overrides;
  std::vector<double> values;  ///< of the axes, one or two
  int start = -1;              ///< number of the drawn start; −1: the scene's own start
};

/// A sequence of runs.
struct Chain {
  std::string branch;  ///< "up", "down", "start 3"; "grid" for a basin
  std::vector<ChainLink> links;
};

/// Progress of all chains, in runs.
struct ChainProgress {
  std::size_t done = 0, total = 0;
};

/// Results of all chains.
struct SettledRuns {
  std::vector<std::vector<SettledRun>> chains;  ///< in the order of the request
  std::vector<NamedColumn> columns;
  Likeness likeness;
  std::size_t found = 0, made = 0;
  long in_lanes = 0;  ///< steps of made runs that were made together with those of other runs
  double period = 0;  ///< s, of the first run; 0: none
  bool interrupted = false;
};

/// Checks every scene of the chains, then executes missing runs, with chains in parallel on
/// `threads` threads (0: all cores). Throws SceneError.
SettledRuns settle(const Study& study, const AttractorPlan& plan, const char* table,
                   const std::vector<Chain>& chains, AttractorStore& store, int threads, StopToken stop,
                   const std::function<void(const ChainProgress&)>& on_progress);

/// End of a run, as start of another one.
struct Handed {
  State state;
  /// Rad, of the scene's drives; NaN for drives that prescribe no speed.
  std::vector<double> drive_angles;
};

/// Starts a scene from the end of a run, whose value may differ: sets the angles of its drives and returns
/// the start.
State take_over(Scene& scene, const Handed& from, const StopToken& stop);

/// The scene of a run. Throws SceneError.
Scene scene_of(const Study& study, const AttractorPlan& plan, const ChainLink& link, const StopToken& stop);

/// KEY=VALUE of every key of an axis, for an index in its list of values.
std::vector<std::string> settings_at(const Axis& axis, std::size_t place);

}  // namespace freeplay
