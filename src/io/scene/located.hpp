// From an error in terms of the model to the place in the file that the scene came from.
#pragma once

#include "mechanism/error.hpp"

namespace freeplay {

struct Scene;

/// FILE:LINE:COL: key: what is wrong.
SceneError located(const Scene& scene, const ModelError& error);

/// What f() returns; what it finds wrong with the scene, at its place in the file.
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
