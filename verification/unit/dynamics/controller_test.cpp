// Controllers: refusals of the reader, canonical text, exact Jacobians at and within the limit, small
// motions about the target, and the order of a method across the limit.
#include "dynamics/assembly/assembly.hpp"
#include "dynamics/assembly/equilibrium.hpp"
#include "dynamics/assembly/modes.hpp"
#include "dynamics/system.hpp"
#include "io/scene/write_scene.hpp"
#include "verification/references/feedback.hpp"
#include "verification/support/jacobian_check.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;
using Catch::Matchers::Contains;
using test::refusal;

namespace {

const std::string controlled_rotor = test::body("rotor", 2.0, 0.05) + test::pin("main", "ground", "rotor");
const std::string controlled_block = test::body("block", 2.0, 0.05) + test::guide("guide", "ground", "block");
const std::string half_second = "[run]\nduration = 0.5\n";

}  // namespace

TEST_CASE("invalid controllers are refused at their place", "[controller]") {
  const auto on_rotor = [](const std::string& lines, const std::string& more = "") {
    return refusal(controlled_rotor + controlled_block + more + "[drives.servo]\njoint = \"main\"\n" + lines +
                   half_second);
  };
  const std::string law = "target_angle = 1\nproportional = 20\n";
  CHECK(on_rotor(law) == "accepted");
  CHECK(on_rotor(law + "derivative = 2\nintegral = \"3 N m/rad s\"\ntorque_limit = 5\nlag = \"1 ms\"\n") ==
        "accepted");
  CHECK_THAT(on_rotor("target_angle = 1\n"),
             Contains("drives.servo: proportional is missing") || Contains("proportional"));
  CHECK_THAT(on_rotor(law + "torque_limit = -5\n"),
             Contains("drives.servo.torque_limit: must be greater than 0, is -5"));
  CHECK_THAT(on_rotor(law + "torque_limit = 0\n"), Contains("torque_limit: must be greater than 0"));
  CHECK_THAT(on_rotor(law + "lag = 0\n"), Contains("drives.servo.lag: must be greater than 0, is 0"));
  CHECK_THAT(on_rotor("target_angle = 1\nproportional = 0\n"),
             Contains("proportional: must be greater than 0"));
  CHECK_THAT(on_rotor(law + "derivative = -1\n"), Contains("derivative: must be 0 or greater"));
  CHECK_THAT(on_rotor(law + "integral = 3\ntracking_time = 0.1\n"),
             Contains("tracking_time: goes with integral and a limit"));
  CHECK_THAT(on_rotor(law + "force_limit = 3\n"), Contains("force_limit"));
  CHECK_THAT(on_rotor(law + "target_position = 1\n"), Contains("needs exactly one of"));
  CHECK_THAT(on_rotor(law + "measured = \"guide\"\n"),
             Contains("drives.servo.measured: must be a revolute joint, \"guide\" is not"));
  CHECK_THAT(on_rotor("target_angle = \"none\"\nproportional = 1\n"), Contains("there is no curve \"none\""));
  CHECK_THAT(on_rotor("target_angle = \"kink\"\nproportional = 1\n",
                      "[curves.kink]\nshape = \"table\"\npoints = [[0, 0], [1, 1], [2, 0]]\n"),
             Contains("drives.servo.target_angle: the curve \"kink\" has a kink at x"));
  CHECK_THAT(on_rotor("target_angle = \"long\"\nproportional = 1\n",
                      "[curves.long]\nshape = \"ramp\"\nto = \"3 mm\"\nrise = 1\n"),
             Contains("is a length, must be an angle"));
  // A joint that cannot be driven so.
  CHECK_THAT(refusal(controlled_block + "[drives.servo]\njoint = \"guide\"\n" + law + half_second),
             Contains("drives.servo.joint: must be a revolute joint, \"guide\" is not"));
  CHECK_THAT(
      refusal(controlled_rotor + "[drives.servo]\njoint = \"main\"\ntarget_position = 1\nproportional = 1\n" +
              half_second),
      Contains("drives.servo.joint: must be a translational joint, \"main\" is not"));
  // A joint driven twice.
  for (const auto* other : {"speed = 3\n", "target_angle = 2\nproportional = 1\n"}) {
    const auto first = std::string("[drives.first]\njoint = \"main\"\n") + other;
    CHECK_THAT(
        on_rotor(law, first),
        Contains("drives.servo.joint: \"main\" is driven by drives.first already; a controller shares"));
  }
  CHECK_THAT(on_rotor(law + "[drives.second]\njoint = \"main\"\nspeed = 3\n"),
             Contains("drives.second.joint: \"main\" is driven by drives.servo already"));
  CHECK(on_rotor(law + "[drives.disturbance]\njoint = \"main\"\ntorque = 3\n") == "accepted");
}

TEST_CASE("the canonical text contains controllers", "[controller]") {
  const auto scene = parse_scene(controlled_rotor + controlled_block +
                                     "[curves.goal]\nshape = \"ramp\"\nto = 0.2\nrise = 0.1\n" +
                                     test::drive("turn", "main", R"(target_angle = "goal"
proportional = 20
derivative = 2
integral = 30
torque_limit = 4
lag = 0.01
tracking_time = 0.3
)") + test::drive("slide", "guide", "measured = \"guide\"\ntarget_position = 0.1\nproportional = 200\n") +
                                     half_second,
                                 "s.toml");
  CHECK(same_facts(parse_scene(to_toml(scene), "again"), scene));
  const System system(scene.mechanism);
  CHECK(system.states() == 2);
  CHECK(system.limiters() == 1);
}

TEST_CASE("the exact Jacobian is correct with controllers", "[controller][jacobian]") {
  // Limits of 1e3 and of 1e-3: within them and beyond.
  const auto* limit = GENERATE("1e3", "1e-3");
  const auto scene = parse_scene(test::body("a", 1.5, 0.2) + test::body("b", 0.7, 0.1) +
                                     test::body("c", 0.4, 0.3) +
                                     test::pin("pin", "ground", "a", {0.1, 0.2}, {0.3, -0.1}) +
                                     test::guide("slide", "a", "b", {0.6, 0.8}, {0.02, 0.03}, {-0.04, 0.05}) +
                                     test::pin("free", "a", "c", {0.1, 0.0}, {0.2, 0.1}) +
                                     test::harmonic("wave", 0.7, 2.1) + R"([drives.place]
joint = "slide"
target_position = "wave"
proportional = 2
derivative = 0.7
integral = 0.9
lag = 0.3
force_limit = )" + limit + R"(
[drives.turn]
joint = "pin"
measured = "free"
target_angle = "wave"
proportional = 3
derivative = 0.4
integral = 0.8
tracking_time = 0.6
torque_limit = )" + limit + "\n" + half_second,
                                 "jacobian");
  CHECK(test::jacobian_error(scene, 7) < 1e-6);
}

TEST_CASE("modes of a controlled joint are those of its control loop", "[controller][equilibrium]") {
  const auto modes_of = [](const std::string& law) {
    const auto scene =
        parse_scene(controlled_rotor + "[drives.servo]\njoint = \"main\"\ntarget_angle = 0.4\n" + law +
                        "torque_limit = 50\n" + half_second,
                    "s");
    const System system(scene.mechanism);
    const auto from = assemble(scene.mechanism, RunOptions::Start::assembled);
    const auto at = find_equilibrium(scene.mechanism, system, from.q, {});
    CHECK(at.state.q[2] == Approx(0.4).epsilon(1e-9));
    return find_modes(system, at, {}).modes;
  };
  // J s² + k_d s + k_p
  const auto pd = modes_of("proportional = 20\nderivative = 0.4\n");
  REQUIRE(pd.size() == 1);
  CHECK(pd[0].s.real() == Approx(-4));
  CHECK(pd[0].s.imag() == Approx(std::sqrt(400 - 16)));
  // (1 + τ s) J s² + k_p = 0 grows.
  const auto lagging = modes_of("proportional = 20\nlag = 0.01\n");
  REQUIRE(lagging.size() == 2);
  for (const auto& mode : lagging)
    CHECK(std::abs((1.0 + 0.01 * mode.s) * 0.05 * mode.s * mode.s + 20.0) < 1e-6);
  CHECK(std::max(lagging[0].s.real(), lagging[1].s.real()) > 0);
}

TEST_CASE("rk4 keeps its fourth order across the limit of a controller", "[controller][order]") {
  // One crossing, at 62 ms, in steps that do not end there.
  const reference::LimitedStep course{0.05, 20, 1.8, 5, 1};
  auto scene = parse_scene(controlled_rotor +
                               "[drives.servo]\njoint = \"main\"\ntarget_angle = 1\nproportional = 20\n"
                               "derivative = 1.8\ntorque_limit = 5\n[run]\nduration = 0.21\n",
                           "s");
  scene.penalty.integrator = Integrator::rk4;
  const auto error_at = [&](double h) {
    scene.penalty.step = h;
    return std::abs(test::simulate(scene, Family::penalty).final_state.q[2] - (1 - course.error(0.21)));
  };
  test::check_order({7e-3, 3.5e-3, 1.75e-3, 0.875e-3}, error_at, 3.7, 4.3);
}
