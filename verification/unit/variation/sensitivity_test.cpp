// Derivatives of event-driven runs: refusals, and random scenes against Richardson-extrapolated
// differences of whole runs.
#include "analysis/sensitivity.hpp"

#include "verification/support/rig.hpp"
#include "verification/unit/variation/varied_scenes.hpp"

using namespace freeplay;
using namespace freeplay::test::varied;
using Catch::Matchers::Contains;

namespace {

std::string ball(const std::string& keys, double restitution = 0.5) {
  return "gravity = [0, -9.81]\n" + test::body("ball", 0.3, 3e-4, keys) +
         test::plane("table", "ground", "ball", 0.05, "hard") + test::surface("hard", restitution) +
         test::run_for(0.4, "start = \"given\"\n[nonsmooth]\nscheme = \"event-driven\"\n");
}

/// A disc meets a resting one, and a third one from the other side.
std::string three_discs(const char* third, double restitution) {
  return test::body("one", 1, 0.004, "position = [-0.25, 0]\nvelocity = [1, 0]\n") +
         test::body("two", 1, 0.004) + test::body("three", 1, 0.004, third) +
         test::discs("left", "one", "two", 0.1, 0.1) + test::discs("right", "two", "three", 0.1, 0.1) +
         test::surface("s", restitution) +
         test::run_for(0.1, "start = \"given\"\n[nonsmooth]\nscheme = \"event-driven\"\n");
}

/// The derivative does not exist, for a reason.
void check_missing(const std::string& text, const std::string& quantity, const std::string& key,
                   const char* reason) {
  const auto q = of(text, {quantity}, {key}).quantities[0];
  CHECK(std::isnan(q.derivatives[0]));
  CHECK_THAT(q.reasons[0], Contains(reason));
}

void compare_with_differences(int scenes) {
  const auto found = compare_random(
      scenes, 20261125, [](int i, auto& r) { return random_case(i, r); }, "nonsmooth",
      [](const std::string&) { return 1e-6; });
  INFO(found.summary());
  CHECK(found.compared > 5 * scenes);
}

}  // namespace

TEST_CASE("keys are taken as the scene and its options spell them", "[sensitivity]") {
  // x = −l cos φ with φ = 2π r after r revolutions, of an arm of length l at a constant speed Ω.
  const std::string arm = R"(
[bodies.arm]
mass = 1
inertia = 1e-3
points = { hub = [-0.05, 0.0], tip = [
  0.05, 0] }
[joints.main]
type = "revolute"
between = ["ground", "arm"]
at = [[0, 0], "hub"]
)" + test::drive("motor", "main", "speed_rpm = 60\n") +
                          "[run]\nrevolutions = 1.3\n";
  const double pi = 3.14159265358979323846, phi = 2 * pi * 0.6, dx = -0.05 * std::sin(phi);
  const auto q = of(arm, {"end.arm.x"},
                    {"run.revolutions", "run.duration", "drives.motor.speed", "bodies.arm.points.hub[0]"},
                    {"run.revolutions=0.6"})
                     .quantities[0];
  CHECK(q.value == Approx(0.05 * std::cos(phi)).epsilon(1e-10));
  // 60 rpm: one revolution a second
  check_derivatives(q, {2 * pi * dx, 2 * pi * dx, 0.6 * dx, -std::cos(phi)}, 1e-9);
}

TEST_CASE("a number within an axis is varied as stated, with the unit axis derived again", "[sensitivity]") {
  // A block slides without friction along the stated axis a: x = −g t² a₀ a₁/(2 |a|²), so that
  // ∂x/∂a₀ = x (1/a₀ − 2 a₀/|a|²) and likewise for a₁. Steps of first order have the same ratio.
  const auto slide = "gravity = [0, -9.81]\n" + test::body("block", 2, 0.01) +
                     test::guide("slide", "ground", "block", {2.0, 0.5}) +
                     test::run_for(0.3, "start = \"given\"\n[nonsmooth]\ntolerance = 1e-12\n");
  const double size = 2.0 * 2.0 + 0.5 * 0.5;
  for (const auto& [formulation, scheme] : {std::pair{"nonsmooth", "event-driven"},
                                            {"nonsmooth", "moreau-jean"},
                                            {"nonsmooth", "automatic"},
                                            {"penalty", "automatic"}}) {
    INFO(formulation << ' ' << scheme);
    const auto q = sensitivities(parse_scene(slide, "s.toml", {fmt::format("nonsmooth.scheme={}", scheme)}),
                                 {.of = {"end.block.x"},
                                  .to = {"joints.slide.axis[0]", "joints.slide.axis[1]"},
                                  .formulation = formulation})
                       .quantities[0];
    CHECK(q.value < 0);
    check_derivatives(q, {q.value * (1 / 2.0 - 2 * 2.0 / size), q.value * (1 / 0.5 - 2 * 0.5 / size)}, 1e-9);
  }
}

TEST_CASE("random stated axes of a plane change the time of an impact as in closed form", "[sensitivity]") {
  // With a the stated axis, the gap of a ball at (1, 1 − g t²/2) is (a₀ y − a₁ x)/|a| − r, so that
  // g t²/2 = 1 − (a₁ + r |a|)/a₀.
  const double g = 9.81;
  for (std::uint64_t i = 0; i < 30; ++i) {
    Draw draw(6201, i);
    const double length = draw.decades(-2, 2), slope = draw.between(-1.2, 0.3);
    const double a0 = exact(length * std::cos(slope)), a1 = exact(length * std::sin(slope)),
                 r = number(draw, 0.01, 0.1), size = std::hypot(a0, a1);
    const double t = std::sqrt(2 / g * (1 - (a1 + r * size) / a0));
    const auto text =
        "gravity = [0, -9.81]\n" + test::body("ball", 1, 1e-3, "position = [1, 1]\n") +
        test::plane("floor", "ground", "ball", r, "s", fmt::format("axis = [{}, {}]\n", a0, a1)) +
        test::surface("s", 0.5, "young = 2e11\npoisson = 0.3\n") +
        test::run_for(t + 0.05, "start = \"given\"\n") + by_events + "[penalty]\ntolerance = 1e-11\n";
    const auto q = sensitivities(parse_scene(text, "s.toml"),
                                 {.of = {"event.1.t"},
                                  .to = {"contacts.floor.axis[0]", "contacts.floor.axis[1]"},
                                  .formulation = draw.chance(0.5) ? "nonsmooth" : "penalty"})
                       .quantities[0];
    INFO(text);
    const double by_a0 = ((a1 + r * size) / (a0 * a0) - r / size) / (g * t),
                 by_a1 = -(1 + r * a1 / size) / (a0 * g * t);
    CHECK(q.value == Approx(t).epsilon(1e-10));
    check_derivatives(q, {by_a0, by_a1}, 0, 1e-7 * std::abs(by_a1));
  }
}

TEST_CASE("an offset of a pin across its rod has the derivative of the twin offset", "[sensitivity]") {
  // With the centre of mass in the middle of the rod, the line of both pins moves away from it by
  // half of an offset at either end: to first order, both offsets give the same mechanism up to a
  // turn of the rod's frame. The gap is a difference of positions of 0.25 m, rounded to 5e-17 m.
  // Values of the difference across the pin are 4e-7 m apart, 3e-3 of the least clearance, so that
  // its slope of about 1 is known to some 5e-10. The time of the impact has 1/(0.2 m/s) of it, 2e-6
  // of its derivative; twice that is allowed.
  for (const double clearance : {1e-3, 1.5e-4}) {
    INFO(clearance);
    const auto all = sensitivities(read_scene(test::scene_file("tests/crank_with_loose_pin"),
                                              {fmt::format("joints.pin.clearance={}", clearance)}),
                                   {.of = {"event.1.t", "event.1.v_n_minus", "event.1.impulse_n"},
                                    .to = {"joints.pin.at[0][1]", "joints.big.at[1][1]"}});
    for (const auto& q : all.quantities) {
      INFO(q.name);
      // The parts of the impulse's derivative cancel to 1e-4.
      CHECK(q.derivatives[0] ==
            Approx(q.derivatives[1]).epsilon(q.name == "event.1.impulse_n" ? 1e-5 : 4e-6));
    }
  }
}

TEST_CASE("quantities and keys without derivatives are refused", "[sensitivity]") {
  const auto refused = [](const std::string& quantity, const std::string& key, const std::string& reason) {
    CHECK_THROWS_WITH(of(ball("position = [0, 0.55]\n"), {quantity}, {key}), Contains(reason));
  };
  for (const std::string event : {"event.0.t", "event.-2294967296.t", "event.+1.t", "event.1e10.t"})
    refused(event, "bodies.ball.mass", event + ": must be event.N.t");
  refused("end.ball.q", "bodies.ball.mass", "is no column of trajectory.csv");
  refused("peak.a", "bodies.ball.mass", "peak.a: \"a\" is no instrument");
  refused("energy.lost", "bodies.ball.mass", "dissipated_in_contacts");
  refused("end.ball.y", "bodies.ball.weight", "bodies.ball.weight: has no value");
  refused("end.ball.y", "gravity", "gravity: is not one number");
  refused("end.ball.y", "gravity[2]", "gravity[2]: is not one number");
  refused("end.ball.y", "nonsmooth.tolerance", "is a numerical setting");
  refused("end.ball.y", "initial.ball.z", "must be initial.BODY.PART");
}

TEST_CASE("motions without a derivative are refused with the reason", "[sensitivity]") {
  // at rest on the table
  check_missing(ball("position = [0, 0.05]\n"), "end.ball.y", "initial.ball.y", "one-sided derivative");
  check_missing(ball("position = [0, 0.55]\n"), "event.9.t", "bodies.ball.mass",
                "the run has 1 contact event");
  check_missing(ball("position = [0, 0.55]\n", 1), "end.ball.y", "surfaces.hard.restitution",
                "values beside 1 are not possible");
  // A disc with upward acceleration touches the floor at its lowest point.
  auto grazing = ball("position = [0, 0.55]\nvelocity = [0, -3]\n");
  grazing.replace(grazing.find("-9.81"), 5, "8.9999999");
  check_missing(grazing, "end.ball.y", "initial.ball.vy", "grazes");
  // A ball meets two that touch.
  check_missing(three_discs("position = [0.2, 0]\n", 1), "end.three.vx", "initial.one.vx",
                "depends on the order of impacts");
}

TEST_CASE("simultaneous impacts state whether their order matters", "[sensitivity]") {
  // Equal discs meet a resting one from both sides. One impact after the other, with e = 0.5, gives
  // (1, 0, −1) → (0.25, 0.75, −1) → (0.25, −0.5625, 0.3125) → (−0.359375, 0.046875, 0.3125), and
  // its mirror image in the other order: the middle disc differs by 0.09375 m/s. With e = 1 both
  // orders give (−1, 0, 1).
  const auto discs = [](double e) { return three_discs("position = [0.25, 0]\nvelocity = [-1, 0]\n", e); };
  check_missing(discs(0.5), "end.two.vx", "initial.one.vx", "change by 0.094 m/s with their order");
  check_missing(discs(1), "end.two.vx", "initial.one.vx", "the derivatives are one-sided");
}

TEST_CASE("derivatives about a rest follow small oscillations", "[sensitivity]") {
  // A hanging pendulum at rest needs no steps of its own. d(end.theta)/d(initial.theta) = cos(ω t) and
  // d(end.omega)/d(initial.theta) = −ω sin(ω t), ω² = m g l/(J + m l²).
  const std::string text = "gravity = [0, -9.81]\n" + test::body("bar", 2, 0.05, "position = [0, -0.4]\n") +
                           test::pin("pivot", "ground", "bar", {}, {0, 0.4}) +
                           test::run_for(3, "start = \"given\"\n[nonsmooth]\nscheme = \"event-driven\"\n");
  const double omega = std::sqrt(2 * 9.81 * 0.4 / (0.05 + 2 * 0.16));
  // The initial rate keeps the constraint: v_x = 0.4 ω.
  const auto s = of(text, {"end.bar.theta", "end.bar.omega"}, {"initial.bar.omega", "initial.bar.vx"});
  const auto by_rate = [&](std::size_t q) {
    return s.quantities[q].derivatives[0] + 0.4 * s.quantities[q].derivatives[1];
  };
  CHECK(by_rate(0) == Approx(std::sin(3 * omega) / omega).margin(1e-6));
  CHECK(by_rate(1) == Approx(std::cos(3 * omega)).margin(1e-6));
}

TEST_CASE("tolerances of a drop propagate to the time of contact", "[sensitivity]") {
  // t = sqrt(2 h/g): σ_t = t/2 sqrt((σ_h/h)² + (σ_g/g)²). The radius shifts h.
  const double g = 9.81, h = 0.5, sigma_h = 1e-3, sigma_g = 0.02, t = std::sqrt(2 * h / g);
  const auto s = of(ball("position = [0, 0.55]\n"), {"event.1.t"}, {"initial.ball.y", "gravity[1]"});
  CHECK(propagated_deviation(s.quantities[0], {sigma_h, sigma_g}) ==
        Approx(0.5 * t * std::hypot(sigma_h / h, sigma_g / g)).epsilon(1e-8));
  CHECK(propagated_deviation(s.quantities[0], {0, 0}) == 0);
}

TEST_CASE("derivatives of random scenes equal extrapolated differences of runs", "[sensitivity]") {
  compare_with_differences(35);
}

TEST_CASE("derivatives of a hundred random scenes equal extrapolated differences", "[sensitivity][slow]") {
  compare_with_differences(100);
}
