#include "plots/export/hdf5_library.hpp"

#include <dlfcn.h>
#include <fmt/format.h>

#include "mechanism/error.hpp"

namespace freeplay::hdf5 {
namespace {

[[noreturn]] void missing(const char* why) {
  throw SceneError(
      fmt::format("--hdf5: the HDF5 library {} cannot be used: {}; Debian: apt install libhdf5-103-1",
                  FREEPLAY_HDF5, why ? why : "no reason given"));
}

void* symbol(void* handle, const char* name) {
  void* found = dlsym(handle, name);
  if (!found) missing(dlerror());
  return found;
}

Library opened() {
  // The file name contains the version of the binary interface that matches the header.
  void* handle = dlopen(FREEPLAY_HDF5, RTLD_NOW | RTLD_LOCAL);
  if (!handle) missing(dlerror());
  Library l;
#define FREEPLAY_FIND(name) l.name = reinterpret_cast<decltype(l.name)>(symbol(handle, #name));
  FREEPLAY_HDF5_FUNCTIONS(FREEPLAY_FIND)
#undef FREEPLAY_FIND
  // At exit HDF5 would retry writes that failed on a full disk, and crash. All files are closed by
  // then.
  l.H5dont_atexit();
  if (l.H5open() < 0) missing("it does not start");
#define FREEPLAY_FIND(name) l.name = *static_cast<hid_t*>(symbol(handle, #name));
  FREEPLAY_HDF5_NUMBERS(FREEPLAY_FIND)
#undef FREEPLAY_FIND
  l.H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);  // errors are reported by this program
  return l;
}

}  // namespace

const Library& library() {
  static const Library l = opened();
  return l;
}

}  // namespace freeplay::hdf5
