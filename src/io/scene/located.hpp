// Adds the position in the scene file to an error that names only a key.
#pragma once

#include "mechanism/error.hpp"

namespace freeplay {

struct Scene;

/// The error as "FILE:LINE:COL: key: message".
SceneError located(const Scene& scene, const ModelError& error);

/// Returns f(); a ModelError from f becomes a SceneError with its position.
template <class F>
auto located_in(const Scene& scene, F f) {
  try {
    return f();
  } catch (const SceneError&) {
    throw;
  } catch (const ModelError& e) {
    throw located(scene, e);
  }
}

}  // namespace freeplay
