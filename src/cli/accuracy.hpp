// The option --accuracy as overrides of a scene.
#pragma once

#include <string>
#include <vector>

namespace freeplay::cli {

/// The overrides, those of `accuracy` (fast, balanced, reference; empty: none) first, so that --set still wins.
std::vector<std::string> with_accuracy(const std::string& accuracy,
                                       const std::vector<std::string>& formulations,
                                       const std::vector<std::string>& overrides);

}  // namespace freeplay::cli
