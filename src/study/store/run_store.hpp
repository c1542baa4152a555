// What the files of runs have in common (sweeps, attractors, ensembles): one SQLite file with a row of `runs` for each run, by the digest
// of all that it depends on, and rows of other tables that name it. A run is stored whole in one transaction, by itself or with others,
// so a program that is stopped at any moment leaves only whole runs, and the next one carries on with what is missing.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "study/store/database.hpp"

namespace freeplay {

/// What a file of runs is made of. Its kind stands in user_version: 0: sweeps with keys of the commit and a list of fields; 1: sweeps
/// with keys that are digests of identities, a row for each harmonic and sample; 2: attractors; 3: sweeps with blobs, by whole numbers,
/// and ensembles.
struct StoreForm {
  long kind = 0;
  std::vector<std::string> definitions;  ///< SQL of its tables, indexes and views, as schema() has it
};

class RunStore {
 public:
  const Database& database() const { return database_; }

 protected:
  /// Opens the file; where it may be written and holds nothing, makes what the form defines. Throws OutputError where it is of
  /// another form.
  RunStore(const std::filesystem::path& file, Database::Access access, const StoreForm& form, StopToken stop);
  ~RunStore() = default;

  Database database_;
};

}  // namespace freeplay
