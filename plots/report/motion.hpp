// The motion of a run as frames that a page can show: poses of the bodies, where loose joints have their play, contact forces.
// Of a long run every so-manieth row, and beside them those between which an event lies, and the first and the last.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <vector>

namespace freeplay {
struct Scene;
}

namespace freeplay::report {

/// How many numbers a frame of the run in a folder has.
long numbers_of_frame(const std::filesystem::path& folder, const Scene* scene);

/// The frames, at most about `most` and those of these times (s) beside; shapes of the scene, where there is one, in the frames of
/// their bodies. Throws SceneError for tables that are wrong.
nlohmann::json motion(const std::filesystem::path& folder, const Scene* scene, long most,
                      const std::vector<double>& times);

}  // namespace freeplay::report
