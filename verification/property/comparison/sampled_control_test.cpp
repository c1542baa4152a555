// Sampled controllers in every scheme against closed forms between the samples: the path at all samples, the
// limit of stability, dead times, the limit cycle of an encoder's resolution, the order of fixed steps, and a
// servo that hunts across a backlash.
#include "verification/references/sampled_control.hpp"
#include "verification/references/feedback.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;
using reference::SampledRotor;

namespace {

constexpr double J = 0.05, h = 5e-3;  // kg m², s

std::string rotor(const std::string& law) {
  return test::body("rotor", 2.0, 0.05) + test::pin("main", "ground", "rotor") +
         test::drive("servo", "main", "sampling_time = 5e-3\n" + law);
}

/// Steps that divide the sampling time, and steps that do not.
const test::Way ways[] = {test::penalty,      test::event_driven,      test::automatic,
                          test::chosen_steps, test::fixed_steps(1e-3), test::fixed_steps(3e-3)};

/// Whether a step ends at t_k = k h, to the rounding of an adaptive time step.
bool ends_at(const Step& step, std::size_t k) {
  return std::abs(step.t1 - static_cast<double>(k) * h) < 1e-13;
}

/// Angles and speeds of the rotor at t_k = k h, k ≥ 1, each the end of a step.
struct Samples {
  std::vector<double> angles, speeds;
  Result run;
};
Samples samples_of(const test::Way& way, const std::string& text, int count) {
  const auto scene = test::scene_by(way, text + test::run_for(count * h));
  Samples seen;
  Simulation simulation(scene, test::name_of(way.family));
  std::vector<double> q(3), v(3);
  test::Listener look;
  look.on_step = [&](const Step& step) {
    if (!ends_at(step, seen.angles.size() + 1)) return;
    step.state(step.t1, q, v);
    seen.angles.push_back(q[2]);
    seen.speeds.push_back(v[2]);
  };
  seen.run = test::finished(simulation, {&look});
  REQUIRE(static_cast<int>(seen.angles.size()) == count);
  return seen;
}

/// Greatest distance of the angles at all samples from the reference, and of the last speed over 10/s.
double distance(SampledRotor& by_hand, const Samples& seen) {
  const auto count = seen.angles.size();
  by_hand.run(static_cast<int>(count));
  double most = std::abs(seen.angles.back() - static_cast<double>(by_hand.x));
  for (std::size_t k = 1; k < count; ++k)
    most = std::max(most, std::abs(seen.angles[k - 1] - by_hand.places[k]));
  return std::max(most, 0.1 * std::abs(seen.speeds.back() - static_cast<double>(by_hand.v)));
}

/// The greatest error of the last second over that of the first one.
double growth(const Samples& seen, double target) {
  const auto second = static_cast<std::size_t>(1 / h), n = seen.angles.size();
  double first = 0, last = 0;
  for (std::size_t k = 0; k < second; ++k) {
    first = std::max(first, std::abs(seen.angles[k] - target));
    last = std::max(last, std::abs(seen.angles[n - 1 - k] - target));
  }
  return last / first;
}

}  // namespace

// Torques are constant between samples, so that every scheme integrates exactly: rounding of some hundred
// steps, times 1e5 for the gains of the loop.
TEST_CASE("a sampled PD controller gives the path of its recursion in every scheme", "[controller]") {
  for (const auto& way : ways) {
    CAPTURE(way.name, way.step);
    const auto seen =
        samples_of(way, rotor("target_angle = 0.5\nproportional = 20\nderivative = 0.4\n"), 100);
    SampledRotor by_hand{.pid = {.target = 0.5L, .kp = 20, .kd = 0.4L, .h = 5e-3L}, .J = 0.05L};
    CHECK(distance(by_hand, seen) < 1e-9);
    CHECK(seen.angles.back() == Approx(0.5755625732890448).epsilon(1e-9));  // the same in Python
    CHECK(std::abs(seen.run.ledger.closure()) < 1e-9 * seen.run.ledger.scale());
  }
}

TEST_CASE("dead times of whole samples and between samples, with integral and limit", "[controller]") {
  const std::string law =
      "target_angle = 0.5\nproportional = 5\nderivative = 0.4\nintegral = 20\ntorque_limit = 1\n";
  const reference::SampledPid pid{
      .target = 0.5L, .kp = 5, .kd = 0.4L, .ki = 20, .limit = 1, .tracking = 0.25L, .h = 5e-3L};
  for (const auto& way : ways) {
    CAPTURE(way.name, way.step);
    SampledRotor whole{.pid = pid, .J = 0.05L, .delay = 3},
        part{.pid = pid, .J = 0.05L, .delay = 1, .rest = 2e-3L};
    const auto by_whole = samples_of(way, rotor(law + "dead_time = 15e-3\n"), 160),
               by_part = samples_of(way, rotor(law + "dead_time = 7e-3\n"), 160);
    CHECK(distance(whole, by_whole) < 1e-9);
    CHECK(distance(part, by_part) < 1e-9);
    CHECK(by_whole.angles.back() == Approx(0.22021497387744637).epsilon(1e-9));  // the same in Python
    CHECK(by_part.angles.back() == Approx(0.2743180529816589).epsilon(1e-9));
  }
}

TEST_CASE("a sampled PD controller loses its stability at Jury's limit", "[controller]") {
  constexpr double kd = 4, target = 1e-3;
  const double limit = reference::jury_limit(J, kd, h);
  CHECK(limit == Approx(3200.0 / 3));
  for (const auto& way : {test::penalty, test::event_driven, test::fixed_steps(1e-3)})
    for (const double share : {0.99, 1.01}) {
      CAPTURE(way.name, share);
      const auto seen =
          samples_of(way,
                     rotor(fmt::format("target_angle = {}\nproportional = {:.17g}\nderivative = {}\n", target,
                                       share * limit, kd)),
                     1200);
      // The recursion: 0.11 and 7.9.
      CHECK((share < 1 ? growth(seen, target) < 0.5 : growth(seen, target) > 2));
    }
}

TEST_CASE("the resolution of an encoder causes a limit cycle of six samples", "[controller]") {
  // The target is in the middle between two values of the encoder.
  const std::string law = "target_angle = 0.305\nproportional = 8\nderivative = 0.3\nresolution = 0.01\n";
  for (const auto& way : ways) {
    CAPTURE(way.name, way.step);
    const auto seen = samples_of(way, rotor(law), 600);
    SampledRotor by_hand{.pid = {.target = 0.305L, .kp = 8, .kd = 0.3L, .h = 5e-3L, .resolution = 0.01L},
                         .J = 0.05L};
    CHECK(distance(by_hand, seen) < 1e-9);
    CHECK(by_hand.pid.least_share > 1e-4);  // no rounding error changes a value of the encoder
    double least = 1, most = 0;
    for (std::size_t k = 400; k < 600; ++k) {
      CHECK(std::abs(seen.angles[k] - seen.angles[k - 6]) < 1e-9);
      least = std::min(least, seen.angles[k]);
      most = std::max(most, seen.angles[k]);
    }
    CHECK(most - least == Approx(3.4e-4).epsilon(1e-6));
  }
}

TEST_CASE("a lag follows the output of a sampled controller", "[controller]") {
  for (const auto& way : {test::penalty, test::event_driven, test::automatic}) {
    CAPTURE(way.name);
    const auto seen =
        samples_of(way, rotor("target_angle = 0.5\nproportional = 5\nderivative = 0.4\nlag = 4e-3\n"), 100);
    SampledRotor by_hand{.pid = {.target = 0.5L, .kp = 5, .kd = 0.4L, .h = 5e-3L}, .J = 0.05L, .lag = 4e-3L};
    // tolerance of 1e-9 a step, some ten steps a sample, margin of 1000
    CHECK(distance(by_hand, seen) < 1e-6);
  }
}

TEST_CASE("fixed steps between the samples of a controller are of second order", "[controller][order]") {
  const auto text = rotor("target_angle = 0.5\nproportional = 5\nderivative = 0.2\n") +
                    "[loads.drag]\ntype = \"torsional-spring-damper\"\nbetween = [\"ground\", \"rotor\"]\n"
                    "damping = 1.0\n";
  SampledRotor by_hand{.pid = {.target = 0.5L, .kp = 5, .kd = 0.2L, .h = 5e-3L}, .J = 0.05L, .c = 1};
  by_hand.run(60);
  const auto error_at = [&](double step) {
    const auto run = test::finished(test::fixed_steps(step), text + test::run_for(60 * h));
    return std::abs(run.final_state.q[2] - static_cast<double>(by_hand.x));
  };
  test::check_order({2.5e-3, 1.25e-3, 0.625e-3}, error_at, 1.9, 2.1);
}

TEST_CASE("a run that begins between two samples takes its first sample at the next whole multiple",
          "[controller]") {
  const auto scene = parse_scene(
      rotor("target_angle = 0.5\nproportional = 20\nderivative = 0.4\n") + test::run_for(0.1), "late");
  State start{0.0125, {0, 0, 0}, {0, 0, 0}, {}};
  Simulation simulation(scene, "nonsmooth", {.start = start});
  test::finished(simulation);
  SampledRotor by_hand{.pid = {.target = 0.5L, .kp = 20, .kd = 0.4L, .h = 5e-3L}, .J = 0.05L};
  by_hand.run(17);  // from 0.015 s to 0.1 s
  CHECK(simulation.state().q[2] == Approx(static_cast<double>(by_hand.x)).epsilon(1e-9));
}

TEST_CASE("a sampled servo hunts across a backlash as its describing function predicts", "[controller]") {
  // A motor of 1 kg with damping pushes a light load, held by friction, across a play of ±1 mm.
  constexpr double b = 1e-3, kp = 200, ki = 1000, kd = 10;
  reference::BacklashCycle harmonic{.J = 1, .c = 5, .b = b, .kp = kp, .ki = ki, .kd = kd, .h = h};
  harmonic.solve(8, 16);
  CHECK(harmonic.omega == Approx(11.003084).epsilon(1e-5));  // the same in Python
  CHECK(harmonic.amplitude == Approx(2.293734e-3).epsilon(1e-5));
  // The third harmonic of the load is a tenth of the motor's amplitude, and the loop passes a third of it.
  CHECK(harmonic.neglected == Approx(0.0433).epsilon(1e-2));
  SampledRotor by_hand{.pid = {.kp = kp, .kd = kd, .ki = ki, .h = 5e-3L},
                       .J = 1,
                       .c = 5,
                       .x = 5e-3L,
                       .play = 1e-3L,
                       .load = 5e-3L};
  by_hand.run(1200);
  const reference::SampledCycle cycle(by_hand.places, 800, h);
  CHECK(cycle.omega == Approx(10.593).epsilon(1e-3));  // the same in Python
  CHECK(cycle.amplitude == Approx(2.1671e-3).epsilon(1e-3));
  // Within the errors of the neglected harmonics: 6.0 % and 17.6 %, with the third one 1.5 % and 3.9 %. All up
  // to the 15th leave what the harmonics above pass, below 0.1 %.
  for (const int most : {1, 3, 15}) {
    CAPTURE(most);
    harmonic.harmonics = most;
    harmonic.solve(8, 16);
    const auto errors = harmonic.errors(8, 16);
    if (most == 3) CHECK(errors.omega < 0.02);
    if (most == 3) CHECK(errors.peak < 0.05);
    CHECK(cycle.omega == Approx(harmonic.omega).epsilon(errors.omega + 1e-3));
    CHECK(cycle.amplitude == Approx(harmonic.peak).epsilon(errors.peak + 1e-3));
  }

  const std::string at = "position = [0.005, 0]\n";
  const std::string text =
      test::body("motor", 1, 0.01, at) + test::body("load", 2e-5, 1e-6, at) +
      test::guide("screw", "ground", "motor") + test::guide("rail", "ground", "load") +
      "[contacts.right]\ntype = \"plane\"\nbetween = [\"motor\", \"load\"]\nat = [[0.001, 0], [0, 0]]\n"
      "axis = [0, 1]\nstiffness = 1e6\nsurface = \"s\"\n"
      "[contacts.left]\ntype = \"plane\"\nbetween = [\"motor\", \"load\"]\nat = [[-0.001, 0], [0, 0]]\n"
      "axis = [0, -1]\nstiffness = 1e6\nsurface = \"s\"\n"
      "[loads.drag]\ntype = \"spring-damper\"\nbetween = [\"ground\", \"motor\"]\nat = [[-1, 0], [0, 0]]\n"
      "damping = 5\n" +
      test::joint_friction("hold", "rail", "force = 5e-4\nregularisation = 1e-5\n") + test::surface("s", 0) +
      test::drive("servo", "screw",
                  fmt::format("measured = \"rail\"\ntarget_position = 0\nsampling_time = {}\n"
                              "proportional = {}\nintegral = {}\nderivative = {}\n",
                              h, kp, ki, kd)) +
      test::run_for(6);
  const test::Way soft{"penalty", Family::penalty, {}, 0, {"surfaces.s.restitution=0.2"}};
  for (const auto& way : {test::event_driven, test::fixed_steps(1e-4), soft}) {
    CAPTURE(way.name);
    std::vector<double> places, q(6), v(6);
    test::Listener look;
    look.on_step = [&](const Step& step) {
      if (!ends_at(step, places.size() + 1)) return;
      step.state(step.t1, q, v);
      places.push_back(q[0]);
    };
    Simulation simulation(test::scene_by(way, text), test::name_of(way.family));
    test::finished(simulation, {&look});
    REQUIRE(places.size() == 1200);
    const reference::SampledCycle seen(places, 800, h);
    // The load's friction is 2 % of the motor's damping force: 0.1 % and 0.3 % in Python. A fixed step closes
    // the play up to 1e-4 s late at 0.02 m/s, 0.2 % of it. Penalty: restitution and regularisation act
    // on the load alone.
    CHECK(seen.omega == Approx(cycle.omega).epsilon(0.01));
    CHECK(seen.amplitude == Approx(cycle.amplitude).epsilon(0.01));
  }
}

TEST_CASE("a sampled axis with gears and backlash follows its linear pieces and plastic impacts",
          "[controller]") {
  const auto scene = read_scene(test::scene_file("axis_with_backlash"), {"drives.servo.sampling_time=2e-3"});
  reference::SwitchedAxis axis;
  axis.J1 = axis.J2 = 0.05L, axis.c1 = axis.c2 = 0.05L, axis.b = 0.01L;
  axis.rigid = true;
  axis.longest = 1e-4L;
  axis.lag = INFINITY;
  reference::SampledPid servo{.kp = 20, .kd = 1, .h = 2e-3L};
  auto y = axis.run({0.03L, 0, 0.03L, 0, 0, 0}, 0);
  for (int k = 0; k < 750; ++k) {
    y[5] = servo.output(y[2]);
    y = axis.advance(y, servo.h);
  }
  CHECK(axis.impacts == 9);
  for (const auto& way : {test::event_driven, test::automatic, test::fixed_steps(1e-4)}) {
    CAPTURE(way.name);
    const auto end = test::finished(way, scene).final_state;
    // Tolerance of 1e-9 a step and impact, margin of 1e4; fixed steps: an impact up to a step late at 0.5
    // rad/s, ten impacts of memory.
    const double most = way.fixed() ? 10 * 0.5 * way.step : 1e-5;
    CHECK(std::abs(-end.q[2] - (-0.03 + static_cast<double>(y[0]))) < most);
    CHECK(std::abs(end.q[5] - (-0.03 + static_cast<double>(y[2]))) < most);
  }
}
