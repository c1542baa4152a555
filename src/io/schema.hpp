// Every key that a scene may hold. The reader refuses what is not listed here and asserts that what it reads
// is; docs/scene.md shows the same rows, and a test compares the two.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace freeplay {

struct SchemaKey {
  std::string_view path;      ///< dotted; * stands for a name that the author chooses
  std::string_view type;      ///< number, text, point, …
  std::string_view unit;      ///< "" for none
  std::string_view fallback;  ///< default as a user would write it; "required", or "–" for left out
  std::string_view meaning;
};

std::span<const SchemaKey> schema();

/// The row of a path such as joints.*.clearance, or nullptr.
const SchemaKey* find_key(std::string_view path);

/// The unit of a scene's key as it is set, joints.gudgeon.clearance; "" for what is no key.
std::string_view unit_of(const std::string& key);

/// Names of keys and tables that may stand in a table ("joints.*", "" for the root), in the order of the schema; "*"
/// among them where the author chooses names.
std::vector<std::string> keys_of(std::string_view table);

/// What such a table describes, with its article: "a joint", "[run]".
std::string_view what_is(std::string_view table);

/// The word nearest in spelling, or "" when none is near.
std::string nearest_word(std::string_view word, const std::vector<std::string>& words);

}  // namespace freeplay
