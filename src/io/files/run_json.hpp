// run.json: result and provenance of a run. docs/reference/results.md describes its sections.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "values/identity.hpp"
#include "values/result.hpp"

namespace freeplay {

struct Scene;

/// The result sections of run.json.
nlohmann::json to_json(const Result& s);

/// The provenance of a run: its identity, part by part and line by line, its options again as JSON,
/// and for users the version, the commit, the scene's text and its overrides.
nlohmann::json provenance(const Scene& scene, const Identity& identity);
/// Provenance of a result that was made from a scene but is not a single run.
nlohmann::json provenance(const Scene& scene);
/// Provenance of a result that was made from several scenes.
nlohmann::json provenance();

/// Note for a scene that does not state its format; "" for one that does.
std::string format_note(const Scene& scene);

/// Writes a document as a file. Bytes in texts that are not UTF-8 are replaced.
void write_json(const std::filesystem::path& path, const nlohmann::json& document);
/// Likewise, with the provenance as the document's section of this name.
void write_json(const std::filesystem::path& path, nlohmann::json document, const nlohmann::json& provenance);

}  // namespace freeplay
