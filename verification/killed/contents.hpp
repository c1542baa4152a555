// The content of a result folder without machine-dependent parts: for comparing results and
// detecting losses.
#pragma once

#include <filesystem>
#include <map>
#include <string>

namespace freeplay::killed {

using Path = std::filesystem::path;
/// By the names of files below a folder, or of runs in a database.
using Contents = std::map<std::string, std::string>;

/// The result files of a folder and of those below it, but for its figures, for databases, for what is hidden and for
/// halves (.partial, run.checkpoint).
Contents results_in(const Path& folder);

/// Every run of a study's database by its key: all that is stored of it but its seconds, in the order in which a run is
/// stored. Equal texts, equal runs, whichever process made them and whenever.
Contents runs_in(const Path& database);

/// Names below a folder that no call which ends in order leaves.
std::string leftovers_in(const Path& folder);

}  // namespace freeplay::killed
