// Reading of scenes by callers that only pass them on, without the definition of Scene, and the positions of
// errors in them.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "mechanism/error.hpp"

namespace freeplay {

struct Scene;

/// As read_scene(). Throws SceneError.
std::shared_ptr<const Scene> open_scene(const std::filesystem::path& file,
                                        const std::vector<std::string>& overrides = {}, bool outside = false);

/// An error that names only a key, with the position of the key in the scene file: "FILE:LINE:COL: key:
/// message".
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
