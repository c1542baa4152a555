// Reads a scene for callers that only pass it on, without including the definition of Scene.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

namespace freeplay {

struct Scene;

/// As read_scene(). Throws SceneError.
std::shared_ptr<const Scene> open_scene(const std::filesystem::path& file,
                                        const std::vector<std::string>& overrides = {}, bool outside = false);

}  // namespace freeplay
