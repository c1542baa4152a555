// Where what was made of a whole study came from.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "study/settings/study.hpp"

namespace freeplay {

/// The provenance of the study's scene, with the study's text for people. Its identity holds besides the scene what
/// the study states and a digest of each file that it names: of scenes by their canonical text, of studies by what
/// they state, of measured files by their bytes. Throws SceneError.
nlohmann::json provenance(const Study& study);

}  // namespace freeplay
