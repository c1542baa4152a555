// Provenance of results that were made from a whole study.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "study/settings/study.hpp"

namespace freeplay {

/// The provenance of the study's scene, and the study's text for users. The identity contains the
/// scene, the statements of the study, and a digest of each file that the study names: of scenes by
/// their canonical text, of studies by their statements, of measured files by their bytes. Throws
/// SceneError.
nlohmann::json provenance(const Study& study);

}  // namespace freeplay
