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
  check_compiled("flores2011/scene", 0.1, penalty_by("rosenbrock4"), 1);
  check_compiled("flores2011/scene", 0.1, penalty_by("dopri5"), 1, {"run.eliminate=false"});
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
