// sweep.json: what the database of a sweep does not state, for figures and reports: the provenance
// of the study, names, units and scales of its axes, measures and derived quantities, its variants,
// units of the statistics, and the verdict.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "measure/turns.hpp"
#include "study/store/results.hpp"

namespace freeplay {

struct Study;

/// Unit of a statistic of turns (docs/reference/study.md); "" if it has none.
std::string_view unit_of(TurnMetrics::Name name);

/// Writes sweep.json beside sweep.db. The write lock of the database keeps processes that share the
/// folder apart. Throws SceneError if the study's scene cannot be read, and OutputError.
void write_sweep_document(const Study& study, const Results& results, const std::filesystem::path& folder,
                          const std::string& verdict = "");

}  // namespace freeplay
