// The HTML page of a result folder: a run, a comparison or a study.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

namespace freeplay::report {

/// End of the start transient, s: the discarded time, or, without one, the first quarter of a turn
/// or the first tenth of the run, whichever is shorter. 0 for a motion without turns, whose start
/// is not a transient.
double start_transient(double discard, const std::optional<double>& turn, double duration);

/// The content of the page of a folder. Throws SceneError for a folder without results or with
/// invalid ones.
nlohmann::json document_of(const std::filesystem::path& folder);

/// The complete page.
std::string report_page(const std::filesystem::path& folder);

}  // namespace freeplay::report
