# find_package(freeplay) defines the target freeplay::freeplay.
include(${CMAKE_CURRENT_LIST_DIR}/link-packages.cmake)
set(freeplay_FOUND ${freeplay_link_packages_found})
if(freeplay_FOUND)
  include(${CMAKE_CURRENT_LIST_DIR}/freeplayTargets.cmake)
else()
  set(freeplay_NOT_FOUND_MESSAGE "${freeplay_link_packages_missing}")
endif()
