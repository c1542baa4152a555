# Writes version.hpp with the commit of the build (for information) and content.hpp with the
# identity of the program. The files are changed only if their content differs.
execute_process(COMMAND git -C ${SOURCE} describe --always --dirty --abbrev=10 OUTPUT_VARIABLE COMMIT
                OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
if(NOT COMMIT)
  set(COMMIT "unknown")
endif()
# Files that determine the bits of a result: the sources that simulate, read, write and measure, and
# the build description. Commands, plots, documents and packaging are excluded.
file(GLOB_RECURSE SOURCES RELATIVE ${SOURCE} ${SOURCE}/src/*.cpp ${SOURCE}/src/*.hpp ${SOURCE}/formulations/*.cpp
     ${SOURCE}/formulations/*.hpp ${SOURCE}/src/*.def ${SOURCE}/formulations/*.def ${SOURCE}/CMakeLists.txt
     ${SOURCE}/scripts/*.cmake)
list(FILTER SOURCES EXCLUDE REGEX "^src/cli/|^scripts/packages\\.cmake$")
list(SORT SOURCES)
set(ALL "")
foreach(file IN LISTS SOURCES)
  file(SHA256 ${SOURCE}/${file} hash)
  string(APPEND ALL "${file}${hash}")
endforeach()
string(SHA256 CONTENT "${ALL}")
string(SUBSTRING ${CONTENT} 0 32 CONTENT)
get_filename_component(FOLDER ${OUTPUT} DIRECTORY)
file(CONFIGURE OUTPUT ${FOLDER}/content.hpp CONTENT
"#pragma once
namespace freeplay::content {
inline constexpr const char* sources = \"${CONTENT}\";  ///< hash of the sources and of the files that say how to build them
inline constexpr const char* compiler = R\"(${COMPILER})\";
inline constexpr const char* flags = R\"(${FLAGS})\";
inline constexpr const char* build = R\"(${BUILD})\";
}  // namespace freeplay::content
" @ONLY)
file(CONFIGURE OUTPUT ${OUTPUT} CONTENT
"#pragma once
namespace freeplay {
inline constexpr const char* version = \"${VERSION}\";
inline constexpr const char* commit = \"${COMMIT}\";
}  // namespace freeplay
" @ONLY)
