// Orders of the integrators on smooth motion, bracketed: a compound pendulum released at rest from 60°,
// against the closed form with elliptic functions.
#include <catch2/catch.hpp>

#include "sim/recorder.hpp"
#include "verification/references/pendulum.hpp"
#include "verification/support.hpp"

using namespace freeplay;

namespace {

constexpr double mass = 0.8, inertia = 0.01, arm = 0.25, gravity = 9.81, amplitude = 1.0471975511965976,
                 t_end = 0.9;

Scene pendulum() {
  // θ is the angle of the body; it hangs along −y, so its angle from the vertical is θ + 90°.
  auto scene = parse_scene(R"(
gravity = [0, -9.81]
[bodies.bar]
mass = 0.8
inertia = 0.01
position = [0.21650635094610965, -0.125]
angle = -0.5235987755982989
[joints.pivot]
type = "revolute"
between = ["ground", "bar"]
at = [[0, 0], [-0.25, 0]]
[run]
duration = 0.9
)",
                           "pendulum");
  return scene;
}

double angle_error(const Scene& scene, Family family) {
  const State start = assemble(scene.mechanism, scene.run.start);
  const System system(scene.mechanism);
  auto formulation = make(family, scene, system, start);
  Recorder recorder(scene, system, std::nullopt);
  REQUIRE(formulation->run(t_end, recorder).status == Ending::Status::finished);
  const double theta = formulation->state().q[2] + 1.5707963267948966;
  return std::abs(
      theta -
      reference::pendulum_state(reference::Pendulum{mass, inertia, arm, gravity, amplitude}, t_end).angle);
}

double order(Scene scene, Family family, double Scene::*, const std::vector<double>& steps,
             double& (*step)(Scene&)) {
  std::vector<double> errors;
  for (double h : steps) {
    step(scene) = h;
    errors.push_back(angle_error(scene, family));
  }
  CAPTURE(errors);
  return test::observed_order(steps, errors);
}

}  // namespace

TEST_CASE("Moreau-Jean is of second order on smooth motion", "[order]") {
  const double p = order(pendulum(), Family::nonsmooth, nullptr, {2e-3, 1e-3, 5e-4, 2.5e-4},
                         [](Scene& s) -> double& { return s.nonsmooth.step; });
  REQUIRE(p > 1.9);
  REQUIRE(p < 2.1);
}

TEST_CASE("rk4 is of fourth order on smooth motion", "[order]") {
  auto scene = pendulum();
  scene.penalty.integrator = Integrator::rk4;
  const double p = order(scene, Family::penalty, nullptr, {2e-2, 1e-2, 5e-3, 2.5e-3},
                         [](Scene& s) -> double& { return s.penalty.step; });
  REQUIRE(p > 3.85);
  REQUIRE(p < 4.15);
}

TEST_CASE("the error of dopri5 falls in proportion to its tolerance", "[order]") {
  const double p = order(pendulum(), Family::penalty, nullptr, {1e-4, 1e-6, 1e-8, 1e-10},
                         [](Scene& s) -> double& { return s.penalty.tolerance; });
  // Error per step against tolerance gives 1 for global error per unit step and 4/5 to 1 for local
  // extrapolation.
  REQUIRE(p > 0.75);
  REQUIRE(p < 1.15);
}
