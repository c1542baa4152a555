// Access to files that a scene or study names. A file of unknown origin must not make this program
// read arbitrary files, so by default only files in its folder or below may be named.
#pragma once

#include <filesystem>
#include <string>

namespace freeplay {

/// The files that may be named.
enum class Reach {
  beside,   ///< in the folder of the naming file or below; links are resolved first
  anywhere  ///< all files, for callers that trust the naming file
};

/// Whether `file` lies in `folder` or below, after resolving links of both.
bool lies_below(const std::filesystem::path& file, const std::filesystem::path& folder);

}  // namespace freeplay
