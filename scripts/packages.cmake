# Settings of the Debian packages, which scripts/package makes with CPack:
#   component program        freeplay          programs, man page, shell completions
#   component development    libfreeplay-dev   headers, static libraries, CMake package, freeplay.pc
#   component python         python3-freeplay  the Python package, only with FREEPLAY_PYTHON
#   component documentation  freeplay-doc      documentation site and example scenes
# The target freeplay-pages makes the files of the packages that no other target makes. These files
# are not part of a plain `cmake --install`.
set(FREEPLAY_MAINTAINER "The Freeplay authors <freeplay@example.org>" CACHE STRING "maintainer of the Debian packages")
set(pages ${PROJECT_BINARY_DIR}/pages)

# --- man page, completions and documentation ---
find_program(FREEPLAY_MKDOCS mkdocs)
find_path(FREEPLAY_KATEX katex.min.js PATHS /usr/share/javascript/katex NO_DEFAULT_PATH)
mark_as_advanced(FREEPLAY_MKDOCS FREEPLAY_KATEX)
if(FREEPLAY_MKDOCS AND FREEPLAY_KATEX)
  set(doc_format html)
  set(doc_commands COMMAND ${PROJECT_SOURCE_DIR}/scripts/docs
                   COMMAND ${CMAKE_COMMAND} -E copy_directory ${PROJECT_SOURCE_DIR}/build/site ${pages}/html)
else() # the pages as Markdown
  set(doc_format markdown)
  set(doc_commands COMMAND ${CMAKE_COMMAND} -E copy_directory ${PROJECT_SOURCE_DIR}/docs ${pages}/markdown)
endif()
add_custom_target(freeplay-pages
  COMMAND ${CMAKE_COMMAND} -E rm -rf ${pages}
  COMMAND ${PROJECT_SOURCE_DIR}/scripts/shell-pages $<TARGET_FILE:freeplay> ${pages}
  COMMAND gzip -9n ${pages}/freeplay.1
  ${doc_commands}
  DEPENDS freeplay freeplay-verify COMMENT "man page, completions and documentation (${doc_format})" VERBATIM)
foreach(component program documentation)
  install(CODE "if(NOT EXISTS \"${pages}/${doc_format}\")
    message(FATAL_ERROR \"the man page and the documentation do not exist; build the target freeplay-pages first\")
  endif()" COMPONENT ${component} EXCLUDE_FROM_ALL)
endforeach()
install(FILES ${pages}/freeplay.1.gz DESTINATION ${CMAKE_INSTALL_MANDIR}/man1 COMPONENT program EXCLUDE_FROM_ALL)
install(FILES ${pages}/freeplay.bash DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions RENAME freeplay
        COMPONENT program EXCLUDE_FROM_ALL)
install(FILES ${pages}/_freeplay DESTINATION ${CMAKE_INSTALL_DATADIR}/zsh/vendor-completions
        COMPONENT program EXCLUDE_FROM_ALL)
install(FILES ${pages}/freeplay.fish DESTINATION ${CMAKE_INSTALL_DATADIR}/fish/vendor_completions.d
        COMPONENT program EXCLUDE_FROM_ALL)
install(DIRECTORY ${pages}/${doc_format} DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/freeplay
        COMPONENT documentation EXCLUDE_FROM_ALL)

# --- all packages ---
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME freeplay)
set(CPACK_PACKAGE_VENDOR "The Freeplay authors")
set(CPACK_PACKAGE_CONTACT "${FREEPLAY_MAINTAINER}")
set(CPACK_RESOURCE_FILE_LICENSE ${PROJECT_SOURCE_DIR}/LICENSE)
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_GROUPING IGNORE) # a package for each component
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_RELEASE 1)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_COMPONENTS_ALL "")
set(about "Freeplay simulates planar mechanisms whose joints have clearance, with
compliant contacts (penalty formulation) and with rigid contacts (nonsmooth
formulation), and compares the results.")

# Sets the name, the section and the description of a component's package, and installs its licence
# as Debian's packages do.
function(freeplay_package component name section summary description)
  string(TOUPPER ${component} upper)
  install(FILES ${PROJECT_SOURCE_DIR}/LICENSE DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/${name} RENAME copyright
          COMPONENT ${component} EXCLUDE_FROM_ALL)
  set(CPACK_COMPONENTS_ALL ${CPACK_COMPONENTS_ALL} ${component} PARENT_SCOPE)
  set(CPACK_DEBIAN_${upper}_PACKAGE_NAME ${name} PARENT_SCOPE)
  set(CPACK_DEBIAN_${upper}_PACKAGE_SECTION ${section} PARENT_SCOPE)
  set(CPACK_DEBIAN_${upper}_DESCRIPTION "${summary}\n${description}" PARENT_SCOPE)
endfunction()

# --- freeplay ---
freeplay_package(program freeplay science "simulation of planar mechanisms with joint clearance"
  "${about}
.
This package contains the program, its man page, and completions for bash,
zsh and fish.")
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SHLIBDEPS ON)
# Reference BLAS and LAPACK: see scripts/serial-blas.cmake.
# HDF5 is loaded by `freeplay export --hdf5`.
set(CPACK_DEBIAN_PROGRAM_PACKAGE_RECOMMENDS "gnuplot-nox, fonts-dejavu-core, libblas3, liblapack3")
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SUGGESTS "ffmpeg, librsvg2-bin, libhdf5-103-1, freeplay-doc")

# --- libfreeplay-dev: depends on the packages of scripts/link-packages.cmake ---
freeplay_package(development libfreeplay-dev libdevel "simulation of planar mechanisms with joint clearance (C++ library)"
  "${about}
.
This package contains the headers and static libraries of the C++ library,
and files for CMake's find_package and for pkg-config.")
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS
    "libfmt-dev (>= 9.1), libsuitesparse-dev (>= 1:5.12), coinor-libipopt-dev (>= 3.11.9), pkg-config")
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SUGGESTS "g++, cmake, freeplay-doc")

# --- python3-freeplay: depends on what setup.py and freeplay.plots need ---
if(FREEPLAY_PYTHON)
  freeplay_package(python python3-freeplay python "simulation of planar mechanisms with joint clearance (Python package)"
    "${about}
.
This package contains the Python package freeplay, which runs scenes and
returns results as pandas data frames.")
  set(CPACK_DEBIAN_PYTHON_PACKAGE_SHLIBDEPS ON)
  # The module is compiled for one version of Python.
  string(REGEX MATCH "^([0-9]+)\\.([0-9]+)" python_version "${PYTHON_VERSION}")
  math(EXPR next_minor "${CMAKE_MATCH_2} + 1")
  set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS "python3 (>= ${python_version}), python3 (<< ${CMAKE_MATCH_1}.${next_minor}), python3-numpy, python3-pandas, python3-tomli-w, python3-matplotlib")
  set(CPACK_DEBIAN_PYTHON_PACKAGE_RECOMMENDS "libblas3, liblapack3")
  set(CPACK_DEBIAN_PYTHON_PACKAGE_SUGGESTS "freeplay-doc")
  # Python's compiled files are made at installation and removed with the package.
  set(control ${PROJECT_BINARY_DIR}/generated/python-package)
  file(CONFIGURE OUTPUT ${control}/postinst CONTENT "#!/bin/sh\nset -e\n[ \"$1\" != configure ] || py3compile -p python3-freeplay\n" @ONLY)
  file(CONFIGURE OUTPUT ${control}/prerm CONTENT "#!/bin/sh\nset -e\npy3clean -p python3-freeplay\n" @ONLY)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_CONTROL_EXTRA "${control}/postinst;${control}/prerm")
endif()

# --- freeplay-doc ---
freeplay_package(documentation freeplay-doc doc "simulation of planar mechanisms with joint clearance (documentation)"
  "${about}
.
This package contains the documentation in /usr/share/doc/freeplay and
example scenes in /usr/share/freeplay/cases.")
set(CPACK_DEBIAN_DOCUMENTATION_PACKAGE_ARCHITECTURE all)
include(CPack)
