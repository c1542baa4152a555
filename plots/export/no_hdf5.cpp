// Replaces hdf5*.cpp in a program built without HDF5.
#include "mechanism/error.hpp"
#include "plots/export/export.hpp"

namespace freeplay {

void require_hdf5() {
  throw SceneError(
      "--hdf5: this program was built without HDF5; Debian: apt install libhdf5-dev, then build it again");
}

Exported export_hdf5(const std::filesystem::path&, const std::filesystem::path&, StopToken) {
  require_hdf5();
  return {};
}

}  // namespace freeplay
