// Derivatives of event-driven runs: refusals, and random scenes against Richardson-extrapolated
// differences of whole runs.
#include "facade/sensitivity.hpp"

#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <string>
#include <vector>

#include "io/files/output_file.hpp"
#include "mechanism/scene.hpp"
#include "verification/support/scene_text.hpp"
#include "verification/support/support.hpp"
#include "verification/support/texts.hpp"
#include "verification/unit/varied_scenes.hpp"

using namespace freeplay;
using namespace freeplay::test::varied;
using Catch::Matchers::Contains;

namespace {

std::string ball(const std::string& keys, double restitution = 0.5) {
  return "gravity = [0, -9.81]\n" + test::body("ball", 0.3, 3e-4, keys) + R"([contacts.table]
type = "plane"
between = ["ground", "ball"]
radius = 0.05
surface = "hard"
[surfaces.hard]
restitution = )" +
         fmt::format("{}\n", restitution) +
         test::run_for(0.4, "start = \"given\"\n[nonsmooth]\nscheme = \"event-driven\"\n");
}

Sensitivities of(const std::string& text, std::vector<std::string> quantities, std::vector<std::string> keys,
                 const std::vector<std::string>& options = {}) {
  return sensitivities(parse_scene(text, "s.toml", options),
                       {.of = std::move(quantities), .to = std::move(keys)});
}

std::string refusal(const std::string& quantity, const std::string& key,
                    const std::vector<std::string>& options = {}) {
  return test::refusal_of<std::exception>(
      [&] { of(ball("position = [0, 0.55]\n"), {quantity}, {key}, options); });
}

/// The reason why the derivative does not exist.
std::string reason(const std::string& text, const std::string& quantity, const std::string& key) {
  const auto s = of(text, {quantity}, {key});
  CHECK(std::isnan(s.quantities[0].derivatives[0]));
  return s.quantities[0].reasons[0];
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
[drives.motor]
joint = "main"
speed_rpm = 60
[run]
revolutions = 1.3
)";
  const double pi = 3.14159265358979323846, phi = 2 * pi * 0.6, dx = -0.05 * std::sin(phi);
  const auto q = of(arm, {"end.arm.x"},
                    {"run.revolutions", "run.duration", "drives.motor.speed", "bodies.arm.points.hub[0]"},
                    {"run.revolutions=0.6"})
                     .quantities[0];
  CHECK(q.value == Approx(0.05 * std::cos(phi)).epsilon(1e-10));
  CHECK(q.derivatives[0] == Approx(2 * pi * dx).epsilon(1e-9));
  CHECK(q.derivatives[1] == Approx(2 * pi * dx).epsilon(1e-9));  // 60 rpm: one revolution a second
  CHECK(q.derivatives[2] == Approx(0.6 * dx).epsilon(1e-9));
  CHECK(q.derivatives[3] == Approx(-std::cos(phi)).epsilon(1e-9));
}

TEST_CASE("quantities and keys without derivatives are refused", "[sensitivity]") {
  CHECK_THAT(refusal("event.0.t", "bodies.ball.mass"), Contains("event.0.t: must be event.N.t"));
  CHECK_THAT(refusal("end.ball.q", "bodies.ball.mass"), Contains("is no column of trajectory.csv"));
  CHECK_THAT(refusal("peak.a", "bodies.ball.mass"), Contains("peak.a: \"a\" is no instrument"));
  CHECK_THAT(refusal("energy.lost", "bodies.ball.mass"), Contains("dissipated_in_contacts"));
  CHECK_THAT(refusal("end.ball.y", "bodies.ball.weight"), Contains("bodies.ball.weight: has no value"));
  CHECK_THAT(refusal("end.ball.y", "gravity"), Contains("gravity: is not one number"));
  CHECK_THAT(refusal("end.ball.y", "gravity[2]"), Contains("gravity[2]: is not one number"));
  CHECK_THAT(refusal("end.ball.y", "nonsmooth.tolerance"), Contains("is a numerical setting"));
  CHECK_THAT(refusal("end.ball.y", "initial.ball.z"), Contains("must be initial.BODY.PART"));
}

TEST_CASE("motions without a derivative are refused with the reason", "[sensitivity]") {
  // at rest on the table
  CHECK_THAT(reason(ball("position = [0, 0.05]\n"), "end.ball.y", "initial.ball.y"),
             Contains("one-sided derivative"));
  CHECK_THAT(reason(ball("position = [0, 0.55]\n"), "event.9.t", "bodies.ball.mass"),
             Contains("the run has 1 contact event"));
  CHECK_THAT(reason(ball("position = [0, 0.55]\n", 1), "end.ball.y", "surfaces.hard.restitution"),
             Contains("values beside 1 are not possible"));
  // A disc with upward acceleration touches the floor at its lowest point.
  auto grazing = ball("position = [0, 0.55]\nvelocity = [0, -3]\n");
  grazing.replace(grazing.find("-9.81"), 5, "8.9999999");
  CHECK_THAT(reason(grazing, "end.ball.y", "initial.ball.vy"), Contains("grazes"));
  // A ball meets two that touch.
  const std::string cradle = test::body("one", 1, 0.004, "position = [-0.25, 0]\nvelocity = [1, 0]\n") +
                             test::body("two", 1, 0.004, "position = [0, 0]\n") +
                             test::body("three", 1, 0.004, "position = [0.2, 0]\n") + R"([contacts.left]
type = "discs"
between = ["one", "two"]
radii = [0.1, 0.1]
surface = "s"
[contacts.right]
type = "discs"
between = ["two", "three"]
radii = [0.1, 0.1]
surface = "s"
[surfaces.s]
restitution = 1
)" + test::run_for(0.1, "start = \"given\"\n[nonsmooth]\nscheme = \"event-driven\"\n");
  CHECK_THAT(reason(cradle, "end.three.vx", "initial.one.vx"), Contains("depends on the order of impacts"));
}

TEST_CASE("simultaneous impacts state whether their order matters", "[sensitivity]") {
  // Equal discs meet a resting one from both sides. One impact after the other, with e = 0.5, gives (1, 0, −1) →
  // (0.25, 0.75, −1) → (0.25, −0.5625, 0.3125) → (−0.359375, 0.046875, 0.3125), and its mirror image in the other
  // order: the middle disc differs by 0.09375 m/s. With e = 1 both orders give (−1, 0, 1).
  const auto discs = [](double e) {
    return test::body("one", 1, 0.004, "position = [-0.25, 0]\nvelocity = [1, 0]\n") +
           test::body("two", 1, 0.004, "position = [0, 0]\n") +
           test::body("three", 1, 0.004, "position = [0.25, 0]\nvelocity = [-1, 0]\n") +
           fmt::format(R"([contacts.left]
type = "discs"
between = ["one", "two"]
radii = [0.1, 0.1]
surface = "s"
[contacts.right]
type = "discs"
between = ["two", "three"]
radii = [0.1, 0.1]
surface = "s"
[surfaces.s]
restitution = {}
)",
                       e) +
           test::run_for(0.1, "start = \"given\"\n[nonsmooth]\nscheme = \"event-driven\"\n");
  };
  CHECK_THAT(reason(discs(0.5), "end.two.vx", "initial.one.vx"),
             Contains("change by 0.094 m/s with their order"));
  CHECK_THAT(reason(discs(1), "end.two.vx", "initial.one.vx"), Contains("the derivatives are one-sided"));
}

TEST_CASE("derivatives about a rest follow small oscillations", "[sensitivity]") {
  // A hanging pendulum at rest needs no steps of its own. d(end.theta)/d(initial.theta) = cos(ω t) and
  // d(end.omega)/d(initial.theta) = −ω sin(ω t), ω² = m g l/(J + m l²).
  const std::string text =
      "gravity = [0, -9.81]\n" + test::body("bar", 2, 0.05, "position = [0, -0.4]\n") + R"([joints.pivot]
type = "revolute"
between = ["ground", "bar"]
at = [[0, 0], [0, 0.4]]
)" + test::run_for(3, "start = \"given\"\n[nonsmooth]\nscheme = \"event-driven\"\n");
  const double omega = std::sqrt(2 * 9.81 * 0.4 / (0.05 + 2 * 0.16));
  // The initial rate keeps the constraint: v_x = 0.4 ω.
  const auto s = of(text, {"end.bar.theta", "end.bar.omega"}, {"initial.bar.omega", "initial.bar.vx"});
  const auto by_rate = [&](std::size_t q) {
    return s.quantities[q].derivatives[0] + 0.4 * s.quantities[q].derivatives[1];
  };
  CHECK(by_rate(0) == Approx(std::sin(3 * omega) / omega).margin(1e-6));
  CHECK(by_rate(1) == Approx(std::cos(3 * omega)).margin(1e-6));
}

TEST_CASE("tolerances of a drop propagate to the time of contact", "[sensitivity][program]") {
  // t = sqrt(2 h/g): σ_t = t/2 sqrt((σ_h/h)² + (σ_g/g)²). The radius shifts h.
  const double g = 9.81, h = 0.5, sigma_h = 1e-3, sigma_g = 0.02, t = std::sqrt(2 * h / g);
  const auto s = of(ball("position = [0, 0.55]\n"), {"event.1.t"}, {"initial.ball.y", "gravity[1]"});
  CHECK(propagated_deviation(s.quantities[0], {sigma_h, sigma_g}) ==
        Approx(0.5 * t * std::hypot(sigma_h / h, sigma_g / g)).epsilon(1e-8));
  CHECK(propagated_deviation(s.quantities[0], {0, 0}) == 0);
  test::TemporaryFolder folder;
  const auto scene = (folder.path() / "ball.toml").string();
  write_file(scene, ball("position = [0, 0.55]\n"));
  const auto run = [&](const std::string& words) {
    return test::freeplay(
        fmt::format("sensitivity {} --of event.1.t -o {}/out {}", scene, folder.path().string(), words));
  };
  const auto propagated = run("--spread initial.ball.y=1e-3");
  CHECK(propagated.status == 0);
  CHECK_THAT(propagated.out,
             Contains(fmt::format("standard deviation {:.4g} (first order)", sigma_h / (g * t))));
  CHECK_THAT(run("--spread initial.ball.y").err, Contains("must be KEY=DEVIATION"));
  CHECK_THAT(run("--spread initial.ball.y=-1").err, Contains("must be KEY=DEVIATION"));
  CHECK_THAT(run("").err, Contains("must name at least one key"));
}

TEST_CASE("derivatives of random scenes equal extrapolated differences of runs", "[sensitivity]") {
  const auto found = compare_random(
      100, 20261125, [](int i, auto& r) { return random_case(i, r); }, "nonsmooth",
      [](const std::string&) { return 1e-6; });
  WARN(found.summary);
  CHECK(found.compared > 500);
}
