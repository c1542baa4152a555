// From an error in terms of the model to the place in the file that the scene came from.
#pragma once

#include "model/error.hpp"

namespace freeplay {

struct Scene;

/// FILE:LINE:COL: key: what is wrong.
SceneError located(const Scene& scene, const ModelError& error);

}  // namespace freeplay
