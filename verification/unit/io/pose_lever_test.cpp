// A lever is drawn to the block that slides on it.
#include "io/scene/pose_file.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;

TEST_CASE("a line leads from a lever to its block", "[pose]") {
  // A lever about the origin and a block that slides along it, 0.3 m from its pivot, on a crank.
  const auto text = "format = 2\n" + test::body("lever", 1.0, 0.01) +
                    test::body("block", 0.1, 1e-4, "position = [0.3, 0.0]\n") +
                    test::pin("pivot", "ground", "lever") +
                    test::joint("slide", "translational", "lever", "block", {}, {}, "axis = [1.0, 0.0]\n") +
                    test::run_for(1.0);
  const auto scene = parse_scene(text, "lever.toml");
  int lines = 0;
  for (const auto& shape : pose_shapes(scene, {0, 0, 0, 0.3, 0, 0})) {
    if (shape.kind != "line") continue;
    ++lines;
    CHECK(shape.name == "slide");
    CHECK(shape.at.norm() == Approx(0).margin(1e-15));
    CHECK((shape.more - Vec2{0.3, 0}).norm() == Approx(0).margin(1e-15));
    CHECK(scene.mechanism.bodies[static_cast<std::size_t>(shape.body)].name == "lever");
    CHECK(scene.mechanism.bodies[static_cast<std::size_t>(shape.other)].name == "block");
  }
  CHECK(lines == 1);
}
