// How long names may be. Readers of scenes and studies refuse longer ones; what reads result files takes all that they make.
#pragma once

#include <cstddef>

namespace freeplay {

/// Characters of a name in a scene or a study.
inline constexpr std::size_t longest_name = 100;
/// Characters of a column or an entry of a result file: two names, as a contact between two bodies has, and what is added to
/// them.
inline constexpr std::size_t longest_entry = 2 * longest_name + 50;

}  // namespace freeplay
