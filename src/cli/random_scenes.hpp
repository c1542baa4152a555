// freeplay extremes --strangers N --kinds NAMES: random scenes whose motion is known at every row.
#pragma once

#include <filesystem>

#include "cli/strangers.hpp"

namespace freeplay::cli {

/// Exit status 1 where there is a defect.
int random_scenes(const StrangersRequest& request, const std::filesystem::path& folder);

}  // namespace freeplay::cli
