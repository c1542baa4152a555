// Schema: all keys of one kind of document, a scene, a study or a style of figures. The reader
// refuses keys that are not listed, and asserts that each key it reads is listed. The rows come from
// the `keys()` visitors (io/scene/keys_list.hpp), once for each program. docs/reference/scene.md,
// docs/reference/study.md and docs/reference/figures.md contain the same rows; a test compares them.
// This header has the schema of scenes; study/settings/study_reader.hpp that of studies, and
// plots/drawing/style.hpp that of styles.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include <map>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "io/scene/spelling.hpp"  // IWYU pragma: export

namespace freeplay {

/// One key of a file.
struct SchemaKey {
  std::string path;  ///< dotted path; * stands for a name chosen by the author
  std::string type;  ///< number, text, point, …
  std::string unit;  ///< "" if dimensionless
  /// Default as written in a file; "required", or "–" for an optional key without default.
  std::string fallback;
  std::string meaning;
};

/// The keys of one kind of document.
class Schema {
 public:
  /// A table and its description with an article: "joints.*", "a joint".
  using Tables = std::vector<std::pair<std::string, std::string>>;
  /// `root`: beginning of all paths: "" for a scene, else "study" or "style".
  Schema(std::string root, std::vector<SchemaKey> keys, Tables tables);

  const std::string& root() const { return root_; }
  const std::vector<SchemaKey>& keys() const { return keys_; }
  /// The key of a path such as joints.*.clearance, or nullptr.
  const SchemaKey* find(std::string_view path) const;
  /// Names of keys and subtables that a table may contain ("joints.*", or the root), in the order
  /// of the schema, with "*" if the author chooses names.
  const std::vector<std::string>& keys_of(std::string_view table) const;
  /// Description of a table with its article: "a joint", "[run]".
  std::string_view what_is(std::string_view table) const;

 private:
  std::string root_;
  std::vector<SchemaKey> keys_;
  Tables tables_;
  /// Found once, since every scene of a sweep asks for them.
  std::map<std::string, std::vector<std::string>, std::less<>> names_;
};

/// The schema of scenes.
const Schema& scene_schema();

/// Unit of a scene's key, given with its names as in joints.gudgeon.clearance, or of a number within
/// its list (joints.pin.at[0][1]); "" for an unknown key.
std::string_view unit_of(const std::string& name);

// JSON Schema (draft 4) of a kind of document, for editors and validators. The rows of kinds that
// share a table are merged, so a document that it accepts may still have keys that its choices do
// not read, or lack required ones: `freeplay check` tells.

nlohmann::ordered_json json_schema(const Schema& schema);

}  // namespace freeplay
