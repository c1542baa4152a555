// Schema: all keys of scenes, studies and styles of figures. The reader refuses keys that are not
// listed, and asserts that each key it reads is listed. docs/reference/scene.md,
// docs/reference/study.md and docs/reference/figures.md contain the same rows; a test compares
// them. The rows of a scene come from the `keys()` visitors (io/scene/keys_list.hpp). They are made
// once and live as long as the program.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "io/scene/spelling.hpp"  // IWYU pragma: export

namespace freeplay {

/// One key of a file.
struct SchemaKey {
  std::string_view path;  ///< dotted path; * stands for a name chosen by the author
  std::string_view type;  ///< number, text, point, …
  std::string_view unit;  ///< "" if dimensionless
  /// Default as written in a file; "required", or "–" for an optional key without default.
  std::string_view fallback;
  std::string_view meaning;
};

/// All keys.
std::span<const SchemaKey> schema();

/// Whether the key belongs to a scene. Paths of other keys begin with "study" or "style".
bool of_scene(const SchemaKey& key);

/// The key of a path such as joints.*.clearance, or nullptr.
const SchemaKey* find_key(std::string_view path);

/// Unit of a scene's key, given with its names as in joints.gudgeon.clearance, or of a number within
/// its list (joints.pin.at[0][1]); "" for an unknown key.
std::string_view unit_of(const std::string& name);

/// Names of keys and subtables that a table may contain ("joints.*", or "" for the root), in the
/// order of the schema, with "*" if the author chooses names.
const std::vector<std::string>& keys_of(std::string_view table);

/// Description of such a table with its article: "a joint", "[run]".
std::string_view what_is(std::string_view table);

}  // namespace freeplay
