// A fuzz target for style.toml: any bytes are read as a style of figures, or refused with one
// SceneError.
#include "mechanism/error.hpp"
#include "plots/drawing/style.hpp"
#include "verification/fuzz/judged.hpp"

using namespace freeplay;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    // Another program searches for a font, a hundred times slower than reading: it does so for one
    // in eight.
    const auto text = fuzz::text_of(data, size);
    if (text.find("font") != text.npos && size % 8 != 0) return 0;
    const auto file = fuzz::file_of(data, size, "figures/style.toml");
    const auto style = plots::style_of(file.parent_path().parent_path());
    if (style.formats.empty() || style.colours.empty() || !(style.font_size > 0)) std::abort();
  } catch (const SceneError& e) {
    fuzz::assess(e, fuzz::text_of(data, size));
  }
  return 0;
}
