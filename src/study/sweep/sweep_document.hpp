// sweep.json: what the database of a sweep does not state, for figures: the provenance of the study,
// and names, units and scales of its axes, measures and derived quantities.
#pragma once

#include <filesystem>

namespace freeplay {

struct Study;

/// Writes sweep.json beside sweep.db. Throws SceneError if the study's scene cannot be read, and
/// OutputError.
void write_sweep_document(const Study& study, const std::filesystem::path& folder);

}  // namespace freeplay
