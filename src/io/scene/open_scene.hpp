// Scenes for those who only pass them on, and need not know what a scene is made of.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

namespace freeplay {

struct Scene;

/// What read_scene() reads. Throws SceneError.
std::shared_ptr<const Scene> open_scene(const std::filesystem::path& file,
                                        const std::vector<std::string>& overrides = {}, bool outside = false);

}  // namespace freeplay
