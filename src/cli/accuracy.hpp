// The option --accuracy as overrides of a scene.
#pragma once

#include <string>
#include <vector>

#include "values/family.hpp"

namespace freeplay::cli {

/// The overrides, those of `accuracy` (fast, balanced, reference; empty: none) first, so that --set still wins.
std::vector<std::string> with_accuracy(const std::string& accuracy, const std::vector<Family>& families,
                                       const std::vector<std::string>& overrides);

}  // namespace freeplay::cli
