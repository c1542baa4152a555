# Ipopt loads libblas.so.3 and liblapack.so.3 of the system. If these are a threaded OpenBLAS, it
# creates a thread for every core at program start, which fails and spins under a memory limit. The
# problems here are small, so programs search first in the folders of Debian's reference libraries
# (libblas3, liblapack3). RPATH is used instead of RUNPATH, because only RPATH also applies to the
# dependencies of libraries.
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
