# Writes version.hpp with the commit that is being built; touches it only when something changed.
execute_process(COMMAND git -C ${SOURCE} describe --always --dirty --abbrev=10 OUTPUT_VARIABLE COMMIT
                OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
if(NOT COMMIT)
  set(COMMIT "unknown")
endif()
file(CONFIGURE OUTPUT ${OUTPUT} CONTENT
"#pragma once
namespace freeplay {
inline constexpr const char* version = \"${VERSION}\";
inline constexpr const char* commit = \"${COMMIT}\";
}  // namespace freeplay
" @ONLY)
