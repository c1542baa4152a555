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

/// The result files of a folder and of those below it, except figures, databases, hidden files and
/// incomplete files (.partial, run.checkpoint).
Contents results_in(const Path& folder);

/// Every run of a study's database by its key: all its stored values except times, in the order in
/// which a run is stored. Equal texts mean equal runs, whichever process made them and whenever.
Contents runs_in(const Path& database);

/// Names below a folder that a completed call does not leave.
std::string leftovers_in(const Path& folder);

}  // namespace freeplay::killed
