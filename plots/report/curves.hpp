// The columns of the tables of a run as curves for a page.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>

namespace freeplay::report {

/// Names, units and thinned values of trajectory.csv, forces.csv and each channel of signals.csv;
/// about `most` numbers in all. Throws SceneError for invalid tables.
nlohmann::json curves(const std::filesystem::path& folder, long most);

}  // namespace freeplay::report
