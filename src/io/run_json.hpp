// run.json: what a run amounts to, and where it came from.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "model/scene.hpp"
#include "values/result.hpp"

namespace freeplay {

/// Sections of run.json.
nlohmann::json to_json(const Result& result);
/// Version, commit, scene text, overrides and options.
nlohmann::json provenance(const Scene& scene);

}  // namespace freeplay
