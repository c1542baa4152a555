// A fuzz target for studies: any bytes are read or refused with one SceneError.
#include "study/runs/case_run.hpp"
#include "study/settings/study.hpp"
#include "verification/fuzz/judged.hpp"

using namespace freeplay;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    const auto study = read_study(fuzz::file_of(data, size, "study.toml"));
    settings_text(study);
    if (study.axes.size() < 4) cases(study);
    // Whatever option fails, the study reports its place or remains unchanged.
    for (const auto& v : study.variants)
      for (const auto& set : v.overrides)
        fuzz::assess(in_study(study, SceneError("--set " + set, "key", "is wrong")),
                     fuzz::text_of(data, size));
  } catch (const SceneError& e) {
    fuzz::assess(e, fuzz::text_of(data, size));
  }
  return 0;
}
