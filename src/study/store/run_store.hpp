// Common part of the databases of runs (sweeps, attractors, ensembles): one SQLite file with one
// row in `runs` for each run, with the digest of its identity as key, and rows of other tables that
// refer to it. Each run is stored completely in one transaction, alone or with others. A program
// that is stopped at any time therefore leaves complete runs only, and the next one continues with
// the missing runs.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "study/store/database.hpp"

namespace freeplay {

/// Definition of a database of runs. Its kind is stored in user_version: 0, sweeps with keys made
/// of the commit and a list of fields; 1, sweeps with digests of identities as keys and one row for
/// each harmonic and sample; 2, attractors; 3, ensembles, and sweeps with blobs and integer
/// references.
struct StoreForm {
  long kind = 0;
  /// SQL of tables, indexes and views, as schema() returns it.
  std::vector<std::string> definitions;
};

/// Base class of databases of runs. Owns the Database.
class RunStore {
 public:
  const Database& database() const { return database_; }

 protected:
  /// Opens the file. Creates the definitions in an empty file that is opened for writing. Throws
  /// OutputError if the file has other definitions.
  RunStore(const std::filesystem::path& file, Database::Access access, const StoreForm& form, StopToken stop);
  ~RunStore() = default;

  Database database_;
};

}  // namespace freeplay
