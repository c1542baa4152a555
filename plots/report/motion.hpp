// The motion of a run as frames for a page: poses of the bodies, positions within the clearance of
// joints, contact forces. A long run has every n-th row, the rows before and after each selected
// event, and the first and last row.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <vector>

namespace freeplay {
struct Scene;
}

namespace freeplay::report {

/// Number of values per frame of the run in a folder.
long numbers_of_frame(const std::filesystem::path& folder, const Scene* scene);

/// The frames, about `most` and those beside `times` (s), and the shapes of the scene (if given) in
/// the frames of their bodies. Throws SceneError for invalid tables.
nlohmann::json motion(const std::filesystem::path& folder, const Scene* scene, long most,
                      const std::vector<double>& times);

}  // namespace freeplay::report
