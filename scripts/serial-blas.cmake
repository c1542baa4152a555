# Ipopt asks the system for libblas.so.3 and liblapack.so.3, and where OpenBLAS with threads stands for them it makes a
# thread for every core when the program starts, which under a memory limit fails and spins. The problems here are
# tiny: programs look first where Debian keeps the plain ones (libblas3, liblapack3), also for what libraries ask for,
# which only RPATH says, not RUNPATH.
function(freeplay_serial_blas target)
  set(folders "")
  foreach(name blas lapack)
    set(folder /usr/lib/${CMAKE_LIBRARY_ARCHITECTURE}/${name})
    if(EXISTS ${folder}/lib${name}.so.3)
      list(APPEND folders ${folder})
    endif()
  endforeach()
  if(NOT folders)
    message(STATUS "no plain BLAS and LAPACK (Debian: libblas3 liblapack3): ${target} takes the system's")
    return()
  endif()
  set_target_properties(${target} PROPERTIES INSTALL_RPATH "${folders}" BUILD_WITH_INSTALL_RPATH TRUE)
  target_link_options(${target} PRIVATE -Wl,--disable-new-dtags)
endfunction()
