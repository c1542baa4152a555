// What a page shows of a study: the runs of a sweep as a matrix, the points of a bifurcation or the cells of a basin.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>

namespace freeplay::report {

/// Whether a folder holds sweep.db, bifurcation.csv or basin.csv.
bool holds_study(const std::filesystem::path& folder);

/// Throws SceneError or OutputError for files that are wrong.
nlohmann::json study_document(const std::filesystem::path& folder);

}  // namespace freeplay::report
