// The functions of HDF5 that are used. The library is loaded on demand instead of linked: loading
// it with its dependencies takes 6 ms, more than the whole program, and the rest of the program
// must run on computers without it.
#pragma once

#include <hdf5.h>

// These macros would call the library before it is loaded. library() loads it first.
#undef H5CHECK
#undef H5OPEN
#define H5CHECK
#define H5OPEN

#define FREEPLAY_HDF5_FUNCTIONS(f)                                                                        \
  f(H5dont_atexit) f(H5open) f(H5Eset_auto2) f(H5Pcreate) f(H5Pclose) f(H5Pset_libver_bounds)             \
      f(H5Pset_chunk) f(H5Pset_shuffle) f(H5Pset_deflate) f(H5Pset_chunk_cache) f(H5Pset_obj_track_times) \
          f(H5Zfilter_avail) f(H5Fcreate) f(H5Fclose) f(H5Gcreate2) f(H5Gclose) f(H5Screate)              \
              f(H5Screate_simple) f(H5Sselect_hyperslab) f(H5Sclose) f(H5Tcopy) f(H5Tset_size)            \
                  f(H5Tset_cset) f(H5Tset_strpad) f(H5Tenum_create) f(H5Tenum_insert) f(H5Tclose)         \
                      f(H5Dcreate2) f(H5Dwrite) f(H5Dclose) f(H5Dget_space) f(H5Acreate2) f(H5Awrite)     \
                          f(H5Aclose)
#define FREEPLAY_HDF5_NUMBERS(f)                                                                            \
  f(H5T_NATIVE_DOUBLE_g) f(H5T_IEEE_F64LE_g) f(H5T_NATIVE_INT64_g) f(H5T_STD_I64LE_g) f(H5T_NATIVE_INT8_g)  \
      f(H5T_C_S1_g) f(H5P_CLS_FILE_ACCESS_ID_g) f(H5P_CLS_DATASET_CREATE_ID_g) f(H5P_CLS_GROUP_CREATE_ID_g) \
          f(H5P_CLS_FILE_CREATE_ID_g) f(H5P_CLS_DATASET_ACCESS_ID_g)

namespace freeplay::hdf5 {

struct Library {
// A member name must not be in parentheses.
// NOLINTNEXTLINE(bugprone-macro-parentheses)
#define FREEPLAY_MEMBER(name) decltype(&::name) name = nullptr;
  FREEPLAY_HDF5_FUNCTIONS(FREEPLAY_MEMBER)
#undef FREEPLAY_MEMBER
#define FREEPLAY_MEMBER(name) hid_t name = -1;
  FREEPLAY_HDF5_NUMBERS(FREEPLAY_MEMBER)
#undef FREEPLAY_MEMBER
};

/// Loads the library at the first call. Throws SceneError, which names the package to install.
const Library& library();

}  // namespace freeplay::hdf5
