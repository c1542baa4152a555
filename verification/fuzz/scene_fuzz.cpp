// A fuzz target for scenes (libFuzzer, clang): any text is either read or refused with one SceneError; a
// scene that is read is assembled or refused likewise. Nothing else may happen.
#include <cstddef>
#include <cstdint>
#include <string>

#include "model/assembly.hpp"
#include "model/scene.hpp"
#include "model/system.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    const auto scene = freeplay::parse_scene(std::string(reinterpret_cast<const char*>(data), size), "fuzz");
    if (scene.mechanism.bodies.size() > 20) return 0;
    const freeplay::System system(scene.mechanism);
    freeplay::assemble(scene.mechanism, scene.run.start);
  } catch (const freeplay::ModelError&) {
  }
  return 0;
}
