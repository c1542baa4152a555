// The columns of a run's tables as curves that a page can show.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>

namespace freeplay::report {

/// Of trajectory.csv, forces.csv and each channel of signals.csv: names, units and thinned values; about so many numbers in all.
/// Throws SceneError for tables that are wrong.
nlohmann::json curves(const std::filesystem::path& folder, long most);

}  // namespace freeplay::report
