// The option --accuracy, translated to overrides of a scene.
#pragma once

#include <string>
#include <vector>

#include "values/family.hpp"

namespace freeplay::cli {

/// The overrides preceded by those of `accuracy` (fast, balanced, reference; empty: none), so that
/// --set has precedence.
std::vector<std::string> with_accuracy(const std::string& accuracy, const std::vector<Family>& families,
                                       const std::vector<std::string>& overrides);

}  // namespace freeplay::cli
