// Ensembles as many machines make them: a unit is a start (study/partition/division.hpp), kept in ensemble.db under the digest of all that it
// depends on.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "study/ensemble/ensemble.hpp"
#include "study/partition/division.hpp"
#include "study/store/database.hpp"

namespace freeplay {

/// The starts that are made: tables runs (run, start, failure, steps, rows: a blob of doubles) and numbers (run, name, value).
class EnsembleStore {
 public:
  explicit EnsembleStore(const std::filesystem::path& file, Database::Access access = Database::Access::write,
                         StopToken stop = {});
  /// False where there is none of that key.
  bool find(const std::string& key, StartOutcome& outcome) const;
  void store(const std::string& key, int start, const StartOutcome& outcome) const;

 private:
  Database database_;
};

/// What tells one start from any other: neither how many there are nor on how many threads.
class StartKeys {
 public:
  StartKeys(const Scene& scene, const EnsemblePlan& plan);
  std::string operator()(int start) const;
  /// Of all that starts have in common, and how many they are.
  std::string subject() const;

 private:
  std::string common_;
  int starts_;
};

/// Of a scene that stays as it is. `arguments`: of the command line, scene and options.
Division divided_ensemble(const Scene& scene, const EnsemblePlan& plan, std::vector<std::string> arguments);

}  // namespace freeplay
