// Assesses random scenes in this process (runner.hpp: many scenes, each in its own process).
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "verification/random_scenes/checks/checks.hpp"

namespace freeplay::verification::random_scenes {

/// The checks without a reference, in their order.
std::vector<Check> checks();

/// `falsify` changes the observed results of the run before the assessment (for tests of the
/// checks).
Verdict assess(const RandomScene& scene, const Way& way, const std::function<void(Sight&)>& falsify = {});
/// By several methods, whose references are made once; `seen` after each.
void assess(const RandomScene& scene, std::span<const Way* const> by,
            const std::function<void(const Verdict&)>& seen);

}  // namespace freeplay::verification::random_scenes
