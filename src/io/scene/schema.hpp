// Every key that a scene, a study or a style of figures may hold. The reader refuses what is not listed here and asserts
// that what it reads is; docs/reference/scene.md, docs/reference/study.md and docs/reference/figures.md show the same rows, and a test compares them.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "io/scene/spelling.hpp"  // IWYU pragma: export

namespace freeplay {

struct SchemaKey {
  std::string_view path;      ///< dotted; * stands for a name that the author chooses
  std::string_view type;      ///< number, text, point, …
  std::string_view unit;      ///< "" for none
  std::string_view fallback;  ///< default as a user would write it; "required", or "–" for left out
  std::string_view meaning;
};

std::span<const SchemaKey> schema();

/// Whether it is a scene's; else a study's or a style's, whose paths begin with that word.
bool of_scene(const SchemaKey& key);

/// The row of a path such as joints.*.clearance, or nullptr.
const SchemaKey* find_key(std::string_view path);

/// The unit of a scene's key as it is set, joints.gudgeon.clearance; "" for what is no key.
std::string_view unit_of(const std::string& key);

/// Names of keys and tables that may stand in a table ("joints.*", "" for the root), in the order of the schema; "*"
/// among them where the author chooses names.
const std::vector<std::string>& keys_of(std::string_view table);

/// What such a table describes, with its article: "a joint", "[run]".
std::string_view what_is(std::string_view table);

}  // namespace freeplay
