// A controlled axis with backlash continues from a snapshot at any step bit for bit, with the
// integral and the lag of its controller.
#include "verification/property/comparison/snapshot_check.hpp"
#include "verification/support/scene_text.hpp"

using namespace freeplay;

namespace {

/// A motor under PID control with limit and lag turns a table through gears with backlash.
std::string controlled_axis() {
  return test::body("motor", 1.0, 0.05) + test::body("table", 1.0, 0.05, "position = [0.1, 0.0]\n") +
         test::pin("shaft", "motor", "ground") + test::pin("axis", "ground", "table", {0.1, 0.0}) +
         test::gear("mesh", "motor", "table", {0.05, 0.05},
                    "backlash = 1e-3\nmesh_stiffness = 1e5\nsurface = \"steel\"\n") +
         test::surface("steel", 0.4) + test::drive("servo", "shaft", R"(measured = "axis"
target_angle = 0.3
proportional = 20
derivative = 2
integral = 40
torque_limit = 3
lag = 2e-3
)") + test::run_for(0.4, "start = \"given\"\n") +
         "[penalty]\ncontact = \"kelvin-voigt\"\nkelvin_stiffness = 1e5\n"
         "kelvin_damping = 20\n";
}

}  // namespace

TEST_CASE("a controlled axis continues from any step bit for bit", "[controller][snapshot]") {
  using namespace snapshots;
  check({controlled_axis(), "penalty", {}, {flight, contact}});
  check({controlled_axis(), "penalty", {"penalty.integrator=rosenbrock4"}, {flight, contact}});
  check({controlled_axis(), "nonsmooth", {"nonsmooth.scheme=automatic"}, {flight}});
  // Without restitution, since events do not resolve an accumulation of impacts.
  check({controlled_axis(),
         "nonsmooth",
         {"nonsmooth.scheme=event-driven", "surfaces.steel.restitution=0"},
         {flight, contact}});
  check({controlled_axis(), "nonsmooth", {"nonsmooth.scheme=moreau-jean", "nonsmooth.step=2e-4"}, {flight}});
  check({controlled_axis(), "nonsmooth", {"nonsmooth.scheme=moreau-jean"}, {flight}});
}
