// A file that a scene names, as it was read.
#pragma once

#include <string>

namespace freeplay {

struct ReadFile {
  std::string name;    ///< as the scene names it
  std::string digest;  ///< of its content
};

}  // namespace freeplay
