// A fuzz target for result files: run.json states how to repeat its run, or is refused; tables of
// numbers are read or refused.
#include "io/files/output_file.hpp"
#include "io/files/recorded_run.hpp"
#include "mechanism/error.hpp"
#include "plots/tables/force_table.hpp"
#include "verification/fuzz/judged.hpp"

using namespace freeplay;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const bool document = size > 0 && data[0] == '{';
  try {
    const auto file = fuzz::file_of(data, size, document ? "run.json" : "forces.csv");
    if (document) {
      read_run(file);
    } else {
      auto run = plots::read_force_run(file, "run", 1);
      plots::keep_last_turn(run, nullptr);
      plots::merge(run, 10);
    }
  } catch (const SceneError& e) {
    fuzz::assess(e, fuzz::text_of(data, size));
  } catch (const OutputError& e) {
    fuzz::assess(e, fuzz::text_of(data, size));
  }
  return 0;
}
