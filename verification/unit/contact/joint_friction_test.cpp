// Friction in ideal joints from their reactions: refusals of the reader, the coupled equations
// against closed forms, detection of cases without a motion, snapshots, and the exact Jacobian.
#include "formulations/contact/coupled_friction.hpp"
#include "formulations/penalty/dynamics.hpp"
#include "io/scene/write_scene.hpp"
#include "verification/property/comparison/snapshot_check.hpp"
#include "verification/support/jacobian_check.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;
using Catch::Matchers::Contains;

namespace {

/// Regularised friction of the joint j.
std::string rub(const std::string& keys) {
  return test::joint_friction("rub", "j", "regularisation = 1e-6\n" + keys);
}
/// A rotor of 1 kg about its pin at 0.1 m from its centre, rotating without weight; `keys`: of its friction.
std::string rotor(const std::string& keys) {
  return test::body("b", 1, 0.005, "position = [0.1, 0]\nvelocity = [0, 2]\nangular_velocity = 20\n") +
         test::pin("j", "ground", "b", {0, 0}, {-0.1, 0}) + rub(keys) + test::run_for(0.05) +
         "[penalty]\nintegrator = \"rosenbrock4\"\n";
}
std::string block(const std::string& keys, const std::string& more = "") {
  return "gravity = [0, -9.81]\n" + test::body("b", 1, 0.005, "velocity = [1, 0]\n") +
         test::guide("j", "ground", "b") + rub(keys) + more + test::run_for(0.05);
}

/// The message with which a simulation by the formulation is refused.
std::string refusal(const std::string& text, const std::string& formulation) {
  return test::refusal_of<std::exception>([&] { Simulation(parse_scene(text, "s.toml"), formulation); });
}

}  // namespace

TEST_CASE("invalid keys of joint friction are refused", "[joint-friction]") {
  const std::string pin = "friction = 0.2\npin_radius = 0.01\n";
  test::check_messages(
      [](const std::string& text) { return test::refusal(text); },
      {{rotor("force = 1\n"), "s.toml:13:9: loads.rub.joint: must be a translational joint"},
       {rotor("friction = 0.2\n"), "loads.rub.pin_radius: is missing"},
       {rotor("friction = -0.2\npin_radius = 0.01\n"), "loads.rub.friction: must be 0 or greater"},
       {rotor("friction = 0.2\npin_radius = 0\n"), "loads.rub.pin_radius: must be greater than 0"},
       {rotor(pin + "slider_length = 0.1\n"), "loads.rub.slider_length: belongs to translational joints"},
       {rotor(pin + "static_friction = 0.3\n"), "static_friction and stribeck_speed go together"},
       {rotor(pin + "stribeck_speed = 0.3\n"), "static_friction and stribeck_speed go together"},
       {rotor(pin + "static_friction = 0.1\nstribeck_speed = 1\n"), "must be at least friction, 0.2"},
       {rotor(pin + "force = 1\n"), "loads.rub.force: the bound is either a fixed force or friction"},
       {block(""), "loads.rub.force: is missing"},
       {block("force = 1\npin_radius = 0.1\n"), "loads.rub.pin_radius"},
       {block("friction = 0.1\npin_radius = 0.1\n"), "loads.rub.pin_radius: belongs to revolute joints"},
       {block("friction = 0.1\nslider_length = -1\n"), "loads.rub.slider_length: must be greater than 0"}});
  for (const auto& good : {rotor(pin + "static_friction = 0.3\nstribeck_speed = 0.01\n"),
                           block("friction = 0.1\nslider_length = 0.2\n"), block("force = 1\n")}) {
    const auto scene = parse_scene(good, "s.toml");
    CHECK(to_toml(parse_scene(to_toml(scene), "again")) == to_toml(scene));
  }
}

TEST_CASE("friction bounded by a statically indeterminate reaction is refused", "[joint-friction]") {
  const auto twice = test::guide("second", "ground", "b");
  for (const char* formulation : {"penalty", "nonsmooth"})
    CHECK_THAT(
        refusal(block("friction = 0.1\n", twice), formulation),
        Contains("loads.rub.joint: the reaction of j bounds this friction but is statically indeterminate"));
  CHECK(refusal(block("force = 1\n", twice), "nonsmooth") == "accepted");
}

TEST_CASE("phase-based impact laws are refused with joint friction", "[joint-friction]") {
  const auto text = block("friction = 0.1\n", test::surface("s", 0.5) +
                                                  test::plane("wall", "ground", "b", 0, "s",
                                                              "at = [[0.01, 0], [0, 0]]\naxis = [0, 1]\n") +
                                                  "[nonsmooth]\nimpact_law = \"poisson\"\n");
  CHECK_THAT(refusal(text, "nonsmooth"), Contains("nonsmooth.impact_law: must be \"newton\""));
}

TEST_CASE("self-locking: a rotor whose friction exceeds its cause has no sliding motion",
          "[joint-friction]") {
  // k = μ r m ε/J = 0.5·0.4·0.1/0.015 = 1.33: no ω̇ satisfies the equation.
  const auto text = rotor("friction = 0.5\npin_radius = 0.4\n");
  for (const auto& way : {test::penalty, test::event_driven}) {
    const auto ending = test::simulate(test::scene_by(way, text), way.family).ending;
    CHECK(ending.status == Ending::Status::failed);
    CHECK_THAT(ending.reason, Contains("self-locking"));
  }
  // An impulse stops it: the pin locks. Time stepping computes that, and reports it.
  const auto run = test::finished(test::fixed_steps(1e-4), text);
  CHECK(std::abs(run.final_state.v[2]) < 1e-12);
  CHECK_THAT(test::notes_of(run), Contains("self-locking"));
}

TEST_CASE("coupled friction: one pin in closed form", "[joint-friction]") {
  const auto scene = parse_scene(rotor("friction = 0.3\npin_radius = 0.05\n"), "s.toml");
  const System system(scene.mechanism);
  CoupledFriction c(system);
  REQUIRE(c.size() == 1);
  // λ⁰ = (3, 4), R = (0, g): f = −c √(9 + (4 + g f)²).
  const double base[] = {3, 4};
  c.base(base);
  for (const double g : {0.0, 0.5, 2.0, -2.0, 4.0}) {
    const double column[] = {0, g};
    for (const double factor : {0.2, -0.2}) {
      c.column(0, column);
      c.factor(0) = factor;
      CAPTURE(g, factor);
      const double k = std::abs(factor * g);
      REQUIRE(c.gain() == Approx(k).margin(1e-15));
      REQUIRE(c.solve() == CoupledFriction::Outcome::solved);
      CHECK(c.force(0) == Approx(-factor * std::hypot(3, 4 + g * c.force(0))).epsilon(1e-13));
      CHECK(c.residual() < 1e-14);
      // (1 − k²) f² − 8 k' f − 25 c² = 0 with k' = c² g; of its two roots the one with f's sign.
      const double a = 1 - k * k, b = -8 * factor * factor * g, d = -25 * factor * factor;
      const double root = std::sqrt(b * b - 4 * a * d);
      CHECK(c.force(0) == Approx((-b - std::copysign(root, factor)) / (2 * a)).epsilon(1e-12));
    }
  }
  // With a gain of 1.4 both roots are negative, −0.60 and −1.73: two solutions in one direction,
  // none in the other.
  const double steep[] = {0, 7};
  c.column(0, steep);
  c.factor(0) = 0.2;
  CHECK(c.solve() == CoupledFriction::Outcome::several);
  c.factor(0) = -0.2;
  CHECK(c.solve() == CoupledFriction::Outcome::none);
}

TEST_CASE("the iteration of coupled friction bounds converges, or reports that no solution exists",
          "[joint-friction]") {
  Eigen::VectorXd B(3), image(3);
  for (const double k : {0.1, 0.9, 1.5}) {
    BoundIteration i;
    i.start(Eigen::VectorXd::Zero(3));
    do {
      B = i.bounds();
      image << std::hypot(1, k * B[1]), 0.5 + k * std::abs(1 - B[2]) * 0.5, 0.3 * k * B[0];
    } while (i.refine(image));
    CAPTURE(k, i.count());
    CHECK(i.met());
    CHECK((image - i.bounds()).cwiseAbs().maxCoeff() < 1e-9 * image.maxCoeff());
  }
  BoundIteration i;
  Eigen::VectorXd one(1);
  i.start(Eigen::VectorXd::Zero(1));
  do one[0] = 1 + 1.2 * i.bounds()[0];
  while (i.refine(one));
  CHECK_FALSE(i.met());
}

TEST_CASE("snapshots: friction in pins and guides", "[joint-friction][snapshot]") {
  using namespace test;
  const auto text =
      "gravity = [0, -9.81]\n" + body("crank", 1, 0.002) + body("rod", 0.5, 0.001, "position = [0.2, 0]\n") +
      body("slider", 0.4, 0.001, "position = [0.35, 0]\n") + pin("main", "ground", "crank") +
      pin("big_end", "crank", "rod", {0.05, 0}, {-0.15, 0}) + pin("gudgeon", "rod", "slider", {0.15, 0}) +
      guide("guide", "ground", "slider") +
      joint_friction("rub_main", "main", "friction = 0.2\npin_radius = 0.01\nregularisation = 1e-4\n") +
      joint_friction("rub_guide", "guide",
                     "friction = 0.2\nslider_length = 0.05\nstatic_friction = 0.3\nstribeck_speed = 0.01\n"
                     "regularisation = 1e-4\n") +
      drive("motor", "main", "torque = 0.05\n") + run_for(0.4, "output_step = 1e-3\n") +
      "[penalty]\nintegrator = \"rosenbrock4\"\n";
  snapshots::check({text, "penalty", {}});
  for (const char* option :
       {"nonsmooth.scheme=\"event-driven\"", "nonsmooth.step=1e-3", "nonsmooth.scheme=\"moreau-jean\""})
    snapshots::check({text, "nonsmooth", {option}});
}

TEST_CASE("the exact Jacobian is correct with friction bounded by its reaction",
          "[joint-friction][jacobian]") {
  const auto scene =
      parse_scene(test::two_bodies() +
                      test::joint_friction(
                          "rub_pin", "pin",
                          "friction = 0.4\npin_radius = 0.05\nstatic_friction = 0.6\nstribeck_speed = 0.3\n"
                          "regularisation = 10.0\n") +
                      test::joint_friction("rub_slide", "slide",
                                           "friction = 0.3\nslider_length = 0.2\nregularisation = 10.0\n") +
                      test::run_for(1),
                  "jacobian");
  CHECK(test::jacobian_error(scene, 20261122, 6) < 1e-6);
}
