// Longest names. Readers of scenes and studies refuse longer ones; readers of result files accept
// every name that they can produce.
#pragma once

#include <cstddef>

namespace freeplay {

/// Characters of a name in a scene or a study.
inline constexpr std::size_t longest_name = 100;
/// Characters of a column or entry of a result file: two names, as for a contact between two
/// bodies, plus a suffix.
inline constexpr std::size_t longest_entry = 2 * longest_name + 50;

}  // namespace freeplay
