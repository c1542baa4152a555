// Perturbed starts found from an initial guess nearby equal those found from the given positions,
// to rounding.
#include "io/scene/read_scene.hpp"
#include "study/runs/perturb.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;

TEST_CASE("perturbed starts are the same from an initial guess as from the given positions",
          "[study][near]") {
  for (const char* scene_of : {"flores2011", "four-bar", "six-bar", "seven-body"}) {
    CAPTURE(scene_of);
    const auto scene = open_scene(test::source_folder() / "cases" / scene_of / "scene.toml");
    if (!differ(*scene, {})) continue;
    const auto near = ideal_pose(*scene, {});
    for (int start = 0; start < 2; ++start) {
      const auto a = perturbed(*scene, near, {}, 5, start, {}),
                 b = perturbed(*scene, std::vector<double>(), {}, 5, start, {});
      for (std::size_t i = 0; i < a.mechanism.bodies.size(); ++i) {
        const auto &x = a.mechanism.bodies[i], &y = b.mechanism.bodies[i];
        // Both close to rounding; then the penalty formulation moves the ideal mechanism by up to a
        // revolution.
        CHECK((*x.position - *y.position).norm() <= 1e-9);
        CHECK(std::abs(*x.angle - *y.angle) <= 1e-8);
      }
    }
  }
}

TEST_CASE("an initial guess exists only for mechanisms that close in isolated poses", "[study][near]") {
  CHECK(ideal_pose(*open_scene(test::flores()), {}).size() == 9);
  CHECK(ideal_pose(*open_scene(test::source_folder() / "cases/double-pendulum/scene.toml"), {}).empty());
  CHECK(ideal_pose(*open_scene(test::flores(), {"run.start=equilibrium"}), {}).empty());
}
