// Controllers: refusals of the reader, exact Jacobians at and within the limit, small
// motions about the target, and the order of a method across the limit.
#include "analysis/sensitivity.hpp"
#include "dynamics/assembly/assembly.hpp"
#include "dynamics/assembly/equilibrium.hpp"
#include "dynamics/assembly/modes.hpp"
#include "dynamics/system.hpp"
#include "verification/references/feedback.hpp"
#include "verification/support/jacobian_check.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;
using test::refusal;

namespace {

const std::string controlled_rotor = test::body("rotor", 2.0, 0.05) + test::pin("main", "ground", "rotor");
const std::string controlled_block = test::body("block", 2.0, 0.05) + test::guide("guide", "ground", "block");
const std::string half_second = test::run_for(0.5);

}  // namespace

TEST_CASE("invalid controllers are refused at their place", "[controller]") {
  using namespace test;
  const auto on_rotor = [](const std::string& lines) {
    return refusal(controlled_rotor + controlled_block + drive("servo", "main", lines) + half_second);
  };
  const std::string law = "target_angle = 1\nproportional = 20\n";
  for (const std::string more :
       {"", "derivative = 2\nintegral = \"3 N m/rad s\"\ntorque_limit = 5\nlag = \"1 ms\"\n",
        "[drives.disturbance]\njoint = \"main\"\ntorque = 3\n",
        "sampling_time = \"2 ms\"\ndead_time = \"200 ms\"\nresolution = \"0.1 deg\"\n"})
    CHECK(on_rotor(law + more) == "accepted");
  const char* const twice =
      "drives.servo.joint: \"main\" is driven by drives.first already; a controller shares";
  check_messages(
      on_rotor,
      {{"target_angle = 1\n", "proportional"},
       {law + "torque_limit = -5\n", "drives.servo.torque_limit: must be greater than 0, is -5"},
       {law + "torque_limit = 0\n", "torque_limit: must be greater than 0"},
       {law + "lag = 0\n", "drives.servo.lag: must be greater than 0, is 0"},
       {"target_angle = 1\nproportional = 0\n", "proportional: must be greater than 0"},
       {law + "derivative = -1\n", "derivative: must be 0 or greater"},
       {law + "integral = 3\ntracking_time = 0.1\n", "tracking_time: goes with integral and a limit"},
       {law + "dead_time = 0.01\n", "drives.servo.dead_time: goes with sampling_time"},
       {law + "resolution = 1e-3\n", "drives.servo.resolution: goes with sampling_time"},
       {law + "sampling_time = 0\n", "drives.servo.sampling_time: must be greater than 0, is 0"},
       {law + "sampling_time = 0.01\ndead_time = -0.01\n", "dead_time: must be 0 or greater"},
       {law + "sampling_time = 0.01\ndead_time = 1.01\n",
        "drives.servo.dead_time: must be at most 100 sampling times, 1 s, is 1.01"},
       {law + "sampling_time = 0.01\nresolution = 0\n", "resolution: must be greater than 0"},
       {law + "sampling_time = 0.1\nintegral = 400\ntorque_limit = 5\n",
        "drives.servo.sampling_time: must be at most the tracking time, 0.05 s"},
       {law + "force_limit = 3\n", "force_limit"},
       {law + "target_position = 1\n", "needs exactly one of"},
       {law + "measured = \"guide\"\n", "drives.servo.measured: must be a revolute joint, \"guide\" is not"},
       {"target_angle = \"none\"\nproportional = 1\n", "there is no curve \"none\""},
       {"target_angle = \"kink\"\nproportional = 1\n" + table("kink", "[[0, 0], [1, 1], [2, 0]]"),
        "drives.servo.target_angle: the curve \"kink\" has a kink at x"},
       {"target_angle = \"long\"\nproportional = 1\n" + curve("long", "ramp", "to = \"3 mm\"\nrise = 1\n"),
        "is a length, must be an angle"},
       {law + motor("second", "main", 3),
        "drives.second.joint: \"main\" is driven by drives.servo already"}});
  // Joints that cannot be driven so, or are driven twice.
  check_messages([](const std::string& elements) { return refusal(elements + half_second); },
                 {{controlled_block + drive("servo", "guide", law),
                   "drives.servo.joint: must be a revolute joint, \"guide\" is not"},
                  {controlled_rotor + drive("servo", "main", "target_position = 1\nproportional = 1\n"),
                   "drives.servo.joint: must be a translational joint, \"main\" is not"},
                  {controlled_rotor + motor("first", "main", 3) + drive("servo", "main", law), twice},
                  {controlled_rotor + drive("first", "main", "target_angle = 2\nproportional = 1\n") +
                       drive("servo", "main", law),
                   twice}});
}

TEST_CASE("the exact Jacobian is correct with controllers", "[controller][jacobian]") {
  // Limits of 1e3 and of 1e-3: within them and beyond.
  const auto limit = GENERATE(as<std::string>{}, "1e3", "1e-3");
  const auto scene = parse_scene(
      test::body("a", 1.5, 0.2) + test::body("b", 0.7, 0.1) + test::body("c", 0.4, 0.3) +
          test::pin("pin", "ground", "a", {0.1, 0.2}, {0.3, -0.1}) +
          test::guide("slide", "a", "b", {0.6, 0.8}, {0.02, 0.03}, {-0.04, 0.05}) +
          test::pin("free", "a", "c", {0.1, 0.0}, {0.2, 0.1}) + test::harmonic("wave", 0.7, 2.1) +
          test::drive("place", "slide",
                      "target_position = \"wave\"\nproportional = 2\nderivative = 0.7\n"
                      "integral = 0.9\nlag = 0.3\nforce_limit = " +
                          limit + "\n") +
          test::drive("turn", "pin",
                      "measured = \"free\"\ntarget_angle = \"wave\"\nproportional = 3\nderivative = 0.4\n"
                      "integral = 0.8\ntracking_time = 0.6\ntorque_limit = " +
                          limit + "\n") +
          half_second,
      "jacobian");
  CHECK(test::jacobian_error(scene, 7) < 1e-6);
}

TEST_CASE("the exact Jacobian is correct with sampled controllers", "[controller][jacobian]") {
  const auto scene = parse_scene(
      test::body("a", 1.5, 0.2) + test::body("b", 0.7, 0.1) +
          test::pin("pin", "ground", "a", {0.1, 0.2}, {0.3, -0.1}) +
          test::guide("slide", "a", "b", {0.6, 0.8}, {0.02, 0.03}, {-0.04, 0.05}) +
          test::drive("place", "slide",
                      "target_position = 0.2\nproportional = 2\nderivative = 0.7\nintegral = 0.9\nlag = 0.3\n"
                      "sampling_time = 0.1\ndead_time = 0.25\n") +
          test::drive("turn", "pin", "target_angle = 0.4\nproportional = 3\nsampling_time = 0.2\n") +
          half_second,
      "jacobian");
  CHECK(test::jacobian_error(scene, 7) < 1e-6);
}

TEST_CASE("sampled controllers have neither equilibrium nor derivatives", "[controller][equilibrium]") {
  const auto scene = parse_scene(
      controlled_rotor +
          test::drive("servo", "main", "target_angle = 0.4\nproportional = 20\nsampling_time = 0.01\n") +
          half_second,
      "s");
  const System system(scene.mechanism);
  CHECK(system.sampled() == "servo");
  const auto from = assemble(scene.mechanism, RunOptions::Start::assembled);
  const auto contains = [](const char* text) { return Catch::Matchers::Contains(text); };
  CHECK_THAT(test::refusal_of<ModelError>([&] { find_equilibrium(scene.mechanism, system, from.q, {}); }),
             contains("drives.servo.sampling_time: a sampled controller acts at instants only"));
  for (const char* formulation : {"penalty", "nonsmooth"})
    CHECK_THAT(test::refusal_of<ModelError>([&] {
                 sensitivities(scene, {.of = {"end.rotor.theta"},
                                       .to = {"drives.servo.proportional"},
                                       .formulation = formulation});
               }),
               contains("drives.servo.sampling_time: the motion under a sampled controller"));
}

TEST_CASE("modes of a controlled joint are those of its control loop", "[controller][equilibrium]") {
  const auto modes_of = [](const std::string& law) {
    const auto scene = parse_scene(
        controlled_rotor + test::drive("servo", "main", "target_angle = 0.4\ntorque_limit = 50\n" + law) +
            half_second,
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
  auto scene = parse_scene(
      controlled_rotor +
          test::drive("servo", "main",
                      "target_angle = 1\nproportional = 20\nderivative = 1.8\ntorque_limit = 5\n") +
          test::run_for(0.21),
      "s");
  scene.penalty.integrator = Integrator::rk4;
  const auto error_at = [&](double h) {
    scene.penalty.step = h;
    return std::abs(test::simulate(scene, Family::penalty).final_state.q[2] - (1 - course.error(0.21)));
  };
  test::check_order({7e-3, 3.5e-3, 1.75e-3, 0.875e-3}, error_at, 3.7, 4.3);
}
