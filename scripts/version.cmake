# Writes version.hpp with the commit that is being built; touches it only when something changed.
execute_process(COMMAND git -C ${SOURCE} describe --always --dirty --abbrev=10 OUTPUT_VARIABLE COMMIT
                OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
if(NOT COMMIT)
  set(COMMIT "unknown")
endif()
# What decides the bits of a result: every source of core and library, the compiler and how it is called.
file(GLOB_RECURSE SOURCES RELATIVE ${SOURCE} ${SOURCE}/src/*.cpp ${SOURCE}/src/*.hpp ${SOURCE}/formulations/*.cpp
     ${SOURCE}/formulations/*.hpp)
list(SORT SOURCES)
set(ALL "${BUILD}")
foreach(file IN LISTS SOURCES)
  file(SHA256 ${SOURCE}/${file} hash)
  string(APPEND ALL "${file}${hash}")
endforeach()
string(SHA256 CONTENT "${ALL}")
string(SUBSTRING ${CONTENT} 0 16 CONTENT)
get_filename_component(FOLDER ${OUTPUT} DIRECTORY)
file(CONFIGURE OUTPUT ${FOLDER}/content.hpp CONTENT
"#pragma once
namespace freeplay {
/// Hash of the sources, the compiler and its flags.
inline constexpr const char* content = \"${CONTENT}\";
}  // namespace freeplay
" @ONLY)
file(CONFIGURE OUTPUT ${OUTPUT} CONTENT
"#pragma once
namespace freeplay {
inline constexpr const char* version = \"${VERSION}\";
inline constexpr const char* commit = \"${COMMIT}\";
}  // namespace freeplay
" @ONLY)
