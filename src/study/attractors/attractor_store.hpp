// The results of bifurcations and basins (study/store/run_store.hpp). What is there is not run again, so that a study that was
// interrupted goes on, and its file then holds what it would have held.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "study/attractors/attractor.hpp"
#include "study/runs/section_run.hpp"
#include "study/store/run_store.hpp"

namespace freeplay {

/// What a run came to.
struct SettledRun {
  std::string branch;
  std::vector<double> values;
  std::string failure, doubt;   ///< why it stopped early; why its points are not to be trusted
  std::vector<double> t, rows;  ///< s; columns of each point
  State end;
  Attractor attractor;  ///< by `rows`
  bool finished() const { return failure.empty(); }
};

/// The results file.
class AttractorStore : public RunStore {
 public:
  explicit AttractorStore(const std::filesystem::path& file, StopToken stop);
  /// False where there is none of that key.
  bool find(const std::string& key, SettledRun& run) const;
  void store(const std::string& key, const SettledRun& run, const std::vector<NamedColumn>& columns);
};

}  // namespace freeplay
