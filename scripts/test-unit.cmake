# Writes a translation unit of several test files: the headers of all files, then each file in its
# own namespace.
#   cmake -DUNIT=FILE -DTESTS=A,B,... -P scripts/test-unit.cmake
string(REPLACE "," ";" TESTS "${TESTS}")
set(headers "")
set(bodies "")
foreach(test ${TESTS})
  file(STRINGS ${test} lines REGEX "^#include [<\"].*[>\"]")
  list(FILTER lines EXCLUDE REGEX "\\.(def|inc)\"")
  list(APPEND headers ${lines})
  get_filename_component(name ${test} NAME_WE)
  string(APPEND bodies "namespace ${name} {\n#include \"${test}\"\n}\n")
endforeach()
list(REMOVE_DUPLICATES headers)
list(JOIN headers "\n" headers)
file(WRITE ${UNIT} "${headers}\n\n${bodies}")
