// A fuzz target for measured files: any bytes are read as finite samples with sufficiently even
// spacing, or refused with one SceneError.
#include <cmath>

#include "measure/measurement.hpp"
#include "mechanism/error.hpp"
#include "verification/fuzz/judged.hpp"

using namespace freeplay;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto file = fuzz::file_of(data, size, "data.csv");
  for (const double speed : {20.0, -20.0}) try {
      const auto m = read_measurement(file, speed, 100);
      bool good = m.time.size() == m.acceleration.size() && m.sampling > 0 && std::isfinite(m.sampling) &&
                  std::isfinite(m.uncertainty) && std::isfinite(m.start_angle);
      for (std::size_t i = 0; i < m.time.size(); ++i)
        good = good && std::isfinite(m.time[i]) && std::isfinite(m.acceleration[i]) &&
               (i == 0 || m.time[i] > m.time[i - 1]);
      if (!good) std::abort();
    } catch (const SceneError& e) {
      fuzz::assess(e, fuzz::text_of(data, size));
    }
  return 0;
}
