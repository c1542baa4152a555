// The page of a result folder: a run, a comparison or a study.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>

namespace freeplay::report {

/// Bytes that a page is to stay below; what is thinned is thinned for it.
inline constexpr double most_of_a_page = 5e6;

/// What a page shows of a folder. Throws SceneError for a folder without results, or with such that are wrong.
nlohmann::json document_of(const std::filesystem::path& folder);

/// The page, whole.
std::string report_page(const std::filesystem::path& folder);

}  // namespace freeplay::report
