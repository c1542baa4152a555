// Words as a shell reads them back: for commands that are shown to be run, and for scripts.
#pragma once

#include <string>
#include <vector>

namespace freeplay {

/// POSIX: words of letters, digits and %+,-./:=@_ as they are, others between single quotes; a blank between words.
std::string shell_words(const std::vector<std::string>& words);

}  // namespace freeplay
