// Reads a scene, or the spelling of a value, for callers that only pass it on, without including the definition of
// Scene.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace freeplay {

struct Scene;

/// As read_scene(). Throws SceneError.
std::shared_ptr<const Scene> open_scene(const std::filesystem::path& file,
                                        const std::vector<std::string>& overrides = {}, bool outside = false);

/// Value of a key as the scene's text and overrides spell it, in one line of TOML: also of keys that the
/// canonical text does not have, as run.revolutions and named points. nullopt if they do not state it.
std::optional<std::string> spelled_value(const Scene& scene, const std::string& key);

}  // namespace freeplay
