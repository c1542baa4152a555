// Compiled functions of a mechanism: when a run makes them.
#pragma once

#include <string_view>
#include <utility>

namespace freeplay {

/// Whether a simulation compiles its mechanism with the system's C compiler (docs/theory/compiled.md).
/// The results are bitwise identical with and without.
enum class Compile {
  automatic,  ///< after as many right-hand sides as a compilation costs
  always,     ///< before the first step
  never       ///< never
};
/// The words of the environment variable FREEPLAY_COMPILE.
inline constexpr std::pair<std::string_view, Compile> compile_words[] = {
    {"automatic", Compile::automatic}, {"always", Compile::always}, {"never", Compile::never}};

}  // namespace freeplay
