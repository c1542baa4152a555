// Database of bifurcation diagrams and basins (study/store/run_store.hpp). Stored runs are not
// repeated, so an interrupted study continues, and its file finally has the same contents.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "study/attractors/attractor.hpp"
#include "study/runs/section_run.hpp"
#include "study/store/run_store.hpp"

namespace freeplay {

/// Result of one run.
struct SettledRun {
  std::string branch;
  std::vector<double> values;
  std::string failure, doubt;   ///< reason of an early end; reason for doubtful points
  std::vector<double> t, rows;  ///< times (s); rows of columns, one row for each point
  State end;
  Attractor attractor;  ///< determined from `rows`
  bool finished() const { return failure.empty(); }
};

/// The database.
class AttractorStore : public RunStore {
 public:
  explicit AttractorStore(const std::filesystem::path& file, StopToken stop);
  /// Reads a run; false if there is none with this key.
  bool find(const std::string& key, SettledRun& run) const;
  void store(const std::string& key, const SettledRun& run, const std::vector<NamedColumn>& columns);
};

}  // namespace freeplay
