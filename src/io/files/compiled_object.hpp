// Compiled objects: C text that this program wrote (numerics/trace.hpp), compiled by the system's
// compiler `cc` as a child process and loaded into this process.
//
// Objects are cached in the folder freeplay of $XDG_CACHE_HOME, by default ~/.cache. The name of an
// object is a digest of the text, the compiler and its flags. The folder must belong to the user and
// be closed to all others, and no component below the user's cache may be a symbolic link; otherwise
// nothing is loaded. Each object ends with a digest of its bytes, so that a truncated one is
// compiled again, and holds its own name, so that an object of another text is never called.
// Objects appear by rename: two processes may write the same one.
//
// Contraction to fused multiply-add is off, and the text fixes the order of all operations: the
// digits do not depend on the compiler.
#pragma once

#include <memory>
#include <string>

#include "numerics/trace.hpp"
#include "values/stop.hpp"

namespace freeplay {

struct CompiledObject {
  std::shared_ptr<const void> library;      ///< keeps the functions loaded; null: there are none
  const CompiledFunction* table = nullptr;  ///< the functions in the order of the text
  bool cached = false;                      ///< whether it was in the cache
  std::string reason;                       ///< why there are none
};

/// Loads the object of a text with `functions` functions, and compiles it first if the cache does not
/// have it. Never throws for a lack of compiler, cache or permission; throws Interrupted on a stop
/// request.
CompiledObject compiled_object(const std::string& text, int functions, StopToken stop = {});

}  // namespace freeplay
