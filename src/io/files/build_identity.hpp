// Version and identity of the compiled program. Their values change with every commit, so that only
// build_identity.cpp includes the generated headers.
#pragma once

#include <string>

namespace freeplay {

struct BuildIdentity {
  const char* version;
  const char* commit;   ///< for information; not part of a run's identity
  const char* sources;  ///< hash of the sources and of the files that say how to build them
  const char* compiler;
  const char* flags;
  const char* build;  ///< CMAKE_BUILD_TYPE
};
BuildIdentity build_identity();

/// VERSION (COMMIT), for users.
std::string version_text();

}  // namespace freeplay
