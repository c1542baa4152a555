// The parts of a page about periodic motions (orbit.json), their branches (continue.json) and Lyapunov
// exponents (lyapunov.json): tables of their results, and their figures as pictures.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>

namespace freeplay::report {

/// Whether a folder has results of `freeplay continue` or `freeplay lyapunov`.
bool holds_motions(const std::filesystem::path& folder);

/// The content of a page of these results alone, without tables.
nlohmann::json motions_document(const std::filesystem::path& folder);

/// Adds the tables and pictures of all these results in the folder to a page. Throws SceneError for invalid
/// files.
void add_motions(const std::filesystem::path& folder, nlohmann::json& document);

}  // namespace freeplay::report
