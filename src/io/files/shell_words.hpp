// Quoting of words for a POSIX shell, for displayed commands and for scripts.
#pragma once

#include <string>
#include <vector>

namespace freeplay {

/// Joins words with blanks. Words of letters, digits and %+,-./:=@_ stay as they are; others are
/// single-quoted.
std::string shell_words(const std::vector<std::string>& words);

}  // namespace freeplay
