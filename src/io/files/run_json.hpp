// run.json: what a run amounts to, and where it came from.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "values/identity.hpp"
#include "values/result.hpp"

namespace freeplay {

struct Scene;

/// Sections of run.json.
nlohmann::json to_json(const Result& s);

/// Where a run came from: its identity, part by part and line by line, with the options of it once more as JSON;
/// and for people version, commit, the scene's text and overrides.
nlohmann::json provenance(const Scene& scene, const Identity& identity);
/// The same of what is made from a scene but is no single run.
nlohmann::json provenance(const Scene& scene);
/// The same of what is made from many scenes.
nlohmann::json provenance();

/// What a scene that states no format is told; "" of one that does.
std::string format_note(const Scene& scene);

/// Writes a document as a file; in texts, bytes that are no UTF-8 are replaced.
void write_json(const std::filesystem::path& path, const nlohmann::json& document);

}  // namespace freeplay
