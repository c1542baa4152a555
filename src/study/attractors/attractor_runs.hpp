// Runs whose section points tell where a motion settles. What is stored already (study/attractors/attractor_store.hpp) is not run again.
//
// A chain is a row of runs of which each may begin where the one before it ended: the places and rates of the bodies, made
// consistent with the next value's constraints by the least movement (dynamics/assembly/assembly.hpp), and first-order states. Contacts
// begin anew. The drives go on from the angles that they had; what is prescribed by a curve is where it was after whole periods.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "study/attractors/attractor_store.hpp"
#include "study/settings/study.hpp"

namespace freeplay {

/// One run: which scene, and of which row of the results it is.
struct ChainLink {
  std::vector<std::string> overrides;
  std::vector<double> values;  ///< of the axes, one or two
  int start = -1;              ///< drawn start, −1: the scene's own
};

struct Chain {
  std::string branch;  ///< "up", "down", "start 3"; of a basin "grid"
  std::vector<ChainLink> links;
};

struct ChainProgress {
  std::size_t done = 0, total = 0;
};

struct SettledRuns {
  std::vector<std::vector<SettledRun>> chains;  ///< as asked for
  std::vector<NamedColumn> columns;
  Likeness likeness;
  std::size_t found = 0, made = 0;
  double period = 0;  ///< s, of the first run; 0: none
  bool interrupted = false;
};

/// Checks every scene of the chains before anything is run; then makes what is missing, chains side by side on `threads`
/// (0: all cores). Throws SceneError.
SettledRuns settle(const Study& study, const AttractorPlan& plan, const char* table,
                   const std::vector<Chain>& chains, AttractorStore& store, int threads, StopToken stop,
                   const std::function<void(const ChainProgress&)>& on_progress);

/// KEY=VALUE of every key of an axis, at a place in its list.
std::vector<std::string> settings_at(const Axis& axis, std::size_t place);

}  // namespace freeplay
