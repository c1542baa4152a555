#include "io/files/build_identity.hpp"

#include "content.hpp"
#include "version.hpp"

namespace freeplay {

BuildIdentity build_identity() {
  return {version, commit, content::sources, content::compiler, content::flags, content::build};
}

std::string version_text() { return std::string(version) + " (" + commit + ")"; }

}  // namespace freeplay
