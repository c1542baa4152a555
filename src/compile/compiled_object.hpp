// Compiled objects: C text that this program wrote (numerics/trace.hpp), compiled by the system's
// compiler `cc` as a child process and loaded into this process.
//
// Objects are cached in the folder freeplay of $XDG_CACHE_HOME, by default ~/.cache. The name of an
// object is a digest of the text, the compiler and its flags. The folder must belong to the user and
// be closed to all others, and no component below the user's cache may be a symbolic link; otherwise
// nothing is loaded. Each object ends with a digest of its bytes and is
// a whole ELF file, so that a truncated one is compiled again, and holds its own name, so that an object
// of another text is never called. Whatever cannot be loaded is compiled again, and what cannot be
// compiled is not tried again by this process. Objects appear by rename: two processes may write the
// same one. The compiler works in a folder of its own below the cache folder, with its temporary files;
// the folder is removed also when this process is killed.
//
// Contraction to fused multiply-add is off, and the text fixes the order of all operations:
// results of all compilers are bitwise identical.
#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "numerics/trace.hpp"
#include "values/stop.hpp"

namespace freeplay {

inline constexpr double longest_compilation = 120;  ///< s

struct CompiledObject {
  std::shared_ptr<const void> library = {};  ///< keeps the functions loaded; null: there are none
  const CompiledFunction* table = nullptr;   ///< the functions in the order of the text
  bool cached = false;                       ///< whether it was in the cache
  std::string reason = {};                   ///< why there are none
};

/// Loads the object of a text with `functions` functions, and compiles it first if the cache does not
/// have it, if `may_compile`. Never throws for a lack of compiler, cache or permission; throws Interrupted on
/// a stop request.
CompiledObject compiled_object(const std::string& text, int functions, StopToken stop = {},
                               bool may_compile = true);

/// Whether the bytes are an ELF object that the loader can map completely.
bool is_whole_object(std::string_view bytes);

}  // namespace freeplay
