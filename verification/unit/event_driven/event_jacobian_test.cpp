// The exact Jacobian of the contact modes of the event-driven scheme against central differences of
// their right-hand side: open, sticking and sliding in either direction, with every film and
// without one, on a mechanism with drives, springs, dampers and a preloaded joint.
#include "dynamics/system.hpp"
#include "formulations/event_driven/event_dynamics.hpp"
#include "verification/support/jacobian_check.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;

namespace {

Scene scene_with(const std::string& film, const std::string& friction) {
  return parse_scene(
      test::two_bodies() + test::surface("steel", 0.6, 0.3, friction) +
          test::pin("loose", "ground", "b", {0.0, 0.1}, {0.2, 0.1},
                    test::loose(0.3, 0.6, "steel") + "bearing_length = 0.2\n") +
          (film.empty()
               ? ""
               : "lubricant = \"oil\"\n[lubricants.oil]\nviscosity = 0.1\nhand_over = 0.05\n" + film) +
          test::drive("motor", "pin", "torque_table = [[0.0, 0.2], [1.0, 1.4]]\n") +
          test::spring("spring", "a", "b", {0.3, 0.1}, {0.2, -0.3}, 40, 0.2, "damping = 3\n") +
          test::joint_friction("rub", "slide", "force = 5\n") + test::run_for(1),
      "jacobian");
}

}  // namespace

TEST_CASE("the exact Jacobian of a contact mode equals differences of its right-hand side",
          "[films][jacobian]") {
  const std::string film =
      GENERATE(as<std::string>{}, "", "film = \"short\"\n", "film = \"long\"\n",
               "film = \"short\"\ncavitation = \"none\"\n", "film = \"long\"\ncavitation = \"none\"\n");
  const std::string friction =
      GENERATE(as<std::string>{}, "", "static_friction = 0.5\nstribeck_speed = 0.8\n",
               "static_friction = 0.5\nstribeck_speed = 0.8\nstribeck_exponent = 1.5\n");
  const auto scene = scene_with(film, friction);
  const System system(scene.mechanism);
  std::mt19937 engine(20261122);
  std::uniform_real_distribution<double> uniform(-1, 1);
  struct Mode {
    bool closed;
    int slip, rub;
  };
  for (const auto mode : {Mode{false, 0, 1}, Mode{false, 0, 0}, Mode{true, 1, -1}, Mode{true, -1, 0}}) {
    EventDynamics f(system, scene.nonsmooth, {0.6}, RowFacts{false}, 1);
    f.contacts[0].closed = mode.closed;
    f.contacts[0].slip = mode.slip;
    f.preloaded[0].slip = mode.rub;
    EventDynamics::Vector x(static_cast<std::size_t>(f.size()));
    for (auto& y : x) y = uniform(engine);
    // The journal of b is at (0, 0.1) + e, in the film or within its hand-over.
    const double angle = 3 * uniform(engine), theta = x[5], length = mode.rub == 0 ? 0.27 : 0.2;
    x[3] = length * std::cos(angle) - (0.2 * std::cos(theta) - 0.1 * std::sin(theta));
    x[4] = 0.1 + length * std::sin(angle) - (0.2 * std::sin(theta) + 0.1 * std::cos(theta));
    CAPTURE(film, friction, mode.closed, mode.slip, mode.rub);
    CHECK(test::jacobian_error(f, x, 0.4) < 1e-6);
  }
}
