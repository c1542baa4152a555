// Runs of compiled mechanisms with tables, stops, teeth and cams against general runs. The claims of
// "compiled" contain random scenes with tables and curves in every scheme.
#include "verification/support/compiled_runs.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;

TEST_CASE("compiled runs with tables, stops, teeth and cams", "[compiled]") {
  const test::CompilerCache cache;
  for (const auto& [name, duration] : {std::pair{"gear-rattle/scene", 0.05},
                                       {"published/exudyn-contact-coordinate/scene", 0.3},
                                       {"published/backlash-joint-driven/scene", 0.3},
                                       {"published/car-axis/scene", 0.2},
                                       {"motor-startup/scene", 0.1},
                                       {"positioning-axis/scene", 0.1},
                                       {"ball-on-table/scene", 0.2}})
    // Interpolated states of event location may be refused.
    for (const auto& way : {test::penalty, test::fixed_steps(1e-4)})
      CHECK(test::check_compiled(name, duration, way, 0.5).compiled.general_parts.empty());
}
