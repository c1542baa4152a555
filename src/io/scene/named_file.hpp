// Files that a file names. A study from elsewhere must not make this program read what lies elsewhere.
#pragma once

#include <filesystem>
#include <string>

namespace freeplay {

/// Which files a study may name.
enum class Reach {
  beside,   ///< those in its folder or below, links followed
  anywhere  ///< all: whoever asked trusts it
};

/// Whether `file` lies in `folder` or below, wherever links on the way to either lead.
bool lies_below(const std::filesystem::path& file, const std::filesystem::path& folder);

}  // namespace freeplay
