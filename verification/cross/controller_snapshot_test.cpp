// A controlled axis with backlash continues from a snapshot at any step bit for bit, with the
// integral and the lag of its controller.
#include "verification/cross/snapshot_check.hpp"

using namespace freeplay;

namespace {

/// A motor under PID control with limit and lag turns a table through gears with backlash.
std::string controlled_axis() {
  return test::body("motor", 1.0, 0.05) + test::body("table", 1.0, 0.05, "position = [0.1, 0.0]\n") +
         test::pin("shaft", "motor", "ground") + test::pin("axis", "ground", "table", {0.1, 0.0}) +
         R"([joints.mesh]
type = "gear"
between = ["motor", "table"]
pitch_radii = [0.05, 0.05]
backlash = 1e-3
mesh_stiffness = 1e5
surface = "steel"
[surfaces.steel]
restitution = 0.4
[drives.servo]
joint = "shaft"
measured = "axis"
target_angle = 0.3
proportional = 20
derivative = 2
integral = 40
torque_limit = 3
lag = 2e-3
[run]
duration = 0.4
start = "given"
[penalty]
contact = "kelvin-voigt"
kelvin_stiffness = 1e5
kelvin_damping = 20
)";
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
