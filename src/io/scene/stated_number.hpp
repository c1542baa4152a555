// A number of a scene by its key, KEY, or KEY[i] or KEY[i][j] within a list, as options, axes of studies and derivatives
// name it. One rule holds for all of them: Scene::set() sets the stated number, and all that follows from it (unit
// axes, radii, durations in turns) is derived again.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace freeplay {

struct Scene;

/// A key and the indices of a number within its list.
struct IndexedKey {
  std::string key;
  std::vector<std::size_t> places;
};
/// Throws ModelError if the brackets do not hold whole numbers.
IndexedKey indexed_key(std::string_view name);

/// Whether a scene equals what its text and overrides say; `facts`: its canonical text. A canonical text counts as a
/// scene built in code, since it does not keep the original spelling.
bool equals_its_text(const Scene& scene, const std::string& facts);

/// A stated number, and the greatest absolute number of its list.
struct StatedNumber {
  double value = 0, greatest = 0;
};
/// As the text and the overrides of the scene state it; for a scene changed in code, and for a number stated with a
/// unit or by another key, as the canonical text does. Throws ModelError if there is no such number.
StatedNumber stated_number(const Scene& scene, const std::string& name);

}  // namespace freeplay
