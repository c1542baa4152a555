// A fuzz target for scenes (libFuzzer, clang): any bytes are read or refused with one SceneError. A
// scene that is read has a canonical text that is read back as the same scene, and is assembled or
// refused likewise. Nothing else may happen.
#include <cmath>

#include "dynamics/assembly/assembly.hpp"
#include "dynamics/system.hpp"
#include "io/files/digest.hpp"
#include "io/scene/read_scene.hpp"
#include "io/scene/write_scene.hpp"
#include "mechanism/scene.hpp"
#include "verification/fuzz/judged.hpp"

using namespace freeplay;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    // Options follow a line of dashes, one a line.
    std::string text(reinterpret_cast<const char*>(data), size);
    std::vector<std::string> options;
    if (const auto cut = text.find("\n---\n"); cut != text.npos) {
      for (std::size_t from = cut + 5; from < text.size();) {
        const auto end = std::min(text.find('\n', from), text.size());
        options.push_back(text.substr(from, end - from));
        from = end + 1;
      }
      text.resize(cut + 1);
    }
    const auto scene = parse_scene(text, "fuzz", options);
    const auto canonical = to_toml(scene);
    if (to_toml(parse_scene(canonical, "canonical")) != canonical) std::abort();
    // Ipopt takes a hundred times as long as reading: one in eight of the small scenes is
    // assembled.
    if (scene.mechanism.bodies.size() > 4 || checksum(canonical) % 8 != 0) return 0;
    try {
      const System system(scene.mechanism);
      assemble(scene.mechanism, scene.run.start);
    } catch (const SceneError&) {
      throw;
    } catch (const ModelError& e) {
      throw located(scene, e);
    }
  } catch (const SceneError& e) {
    fuzz::assess(e, fuzz::text_of(data, size));
  }
  return 0;
}
