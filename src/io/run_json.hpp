// run.json: what a run amounts to, and where it came from.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "io/identity.hpp"
#include "values/result.hpp"

namespace freeplay {

/// Sections of run.json.
nlohmann::json to_json(const Result& result);

/// Where a run came from: its identity, part by part and line by line, with the options of it once more as JSON;
/// and for people version, commit, the scene's text and overrides.
nlohmann::json provenance(const Scene& scene, const Identity& identity);
/// The same of what is made from a scene but is no single run.
nlohmann::json provenance(const Scene& scene);

/// What a scene that states no format is told; "" of one that does.
std::string format_note(const Scene& scene);

/// A run as its run.json tells it.
struct RecordedRun {
  Identity identity;
  Setup setup;  ///< its scene has file, text and overrides of the run, for its provenance
};

/// Throws SceneError for what is no run.json, is damaged, or was made before runs had an identity.
RecordedRun read_run(const std::filesystem::path& file);

}  // namespace freeplay
