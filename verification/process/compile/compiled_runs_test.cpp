// Whole runs of compiled mechanisms against general runs: every digit of the result, and of the rest
// of a run that a snapshot of the compiled one continues. The expected digits are those of the general
// path, which other tests compare with closed forms.
#include "verification/support/compiled_runs.hpp"
#include "verification/support/named.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;
using test::penalty, test::penalty_by, test::event_driven, test::fixed_steps, test::check_compiled;

namespace {

/// The second joint of the four-bar with clearance, too.
const std::vector<std::string> two_clearances{"joints.B.clearance=0.2 mm", "joints.B.bearing_radius=10 mm",
                                              "joints.B.surface=steel"};

}  // namespace

TEST_CASE("compiled runs with adaptive steps: impacts, clearances, and friction that sticks", "[compiled]") {
  const test::CompilerCache cache;
  for (const auto& way : {penalty, event_driven}) check_compiled("flores2011/scene", 0.1, way, 0.02);
  // Jacobians, and states at which a dependent row is not resolved, are refused without a bound.
  check_compiled("flores2011/scene", 0.1, penalty_by("rosenbrock4"), INFINITY);
  check_compiled("flores2011/scene", 0.1, penalty_by("dopri5"), INFINITY, {"run.eliminate=false"});
  for (const auto& way : {penalty, event_driven})
    check_compiled("four-bar/scene", 0.1, way, 0.02, two_clearances);
  check_compiled("block-on-slope/scene", 0.1, event_driven, 0.02);
}

TEST_CASE("compiled runs of fixed steps: impacts, clearances, sticking, dampers, and friction of a joint",
          "[compiled]") {
  const test::CompilerCache cache;
  for (const char* name : {"flores2011/scene", "block-on-slope/scene", "press/scene", "spring-balance/scene",
                           "flores2011-experiment/guide"})
    check_compiled(name, 0.2, fixed_steps(2e-5), 0.01);
  check_compiled("four-bar/scene", 0.2, fixed_steps(2e-5), 0.01, two_clearances);
}

TEST_CASE("compiled runs from concentric journals, which have no row, to their first impacts", "[compiled]") {
  const test::CompilerCache cache;
  // Many steps before the first impact. Concentric journals are evaluated by the general path.
  const auto found = check_compiled("flores2011/scene", 0.05, fixed_steps(2e-6), 1);
  CHECK(found.events_seen > 10);
  CHECK(found.compiled.refused < found.work.steps);
}

// Runs of compiled mechanisms with tables, stops, teeth and cams against general runs. The claims of
// "compiled" contain random scenes with tables and curves in every scheme.

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
