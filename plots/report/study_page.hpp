// Content of the page of a study: the runs of a sweep, the points of a bifurcation or the cells of
// a basin.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>

namespace freeplay::report {

/// Whether a folder has sweep.db, bifurcation.csv or basin.csv.
bool holds_study(const std::filesystem::path& folder);

/// Reads the content of the page. Throws SceneError or OutputError for invalid files.
nlohmann::json study_document(const std::filesystem::path& folder);

}  // namespace freeplay::report
