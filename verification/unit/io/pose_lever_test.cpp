// A lever is drawn to the block that slides on it, and a body to its outline and to the disc on one.
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

TEST_CASE("lines lead from bodies to an outline's nearest point and to the disc on it", "[pose]") {
  const auto text =
      "format = 2\n" + test::body("wheel", 1, 0.01) +
      test::body("crank", 1, 0.01, "position = [0.5, 0.0]\n") + test::pin("hub", "ground", "wheel") +
      test::pin("shaft", "ground", "crank", {0.6, 0}, {0.1, 0}) + test::surface("steel", 0.5) +
      "[contacts.land]\ntype = \"outline\"\nbetween = [\"wheel\", \"crank\"]\n"
      "at = [[0.1, 0.0], [0.0, 0.2]]\npoints = [[0.0, 0.1], [0.2, 0.1], [0.0, 0.3]]\nradius = 0.01\n"
      "stiffness = 1e6\nsurface = \"steel\"\n" +
      test::run_for(1.0);
  const auto scene = parse_scene(text, "land.toml");
  std::vector<PoseShape> lines;
  const double quarter = 0.5 * std::numbers::pi;  // of the wheel
  for (const auto& shape : pose_shapes(scene, {0, 0, quarter, 0.5, 0, 0}))
    if (shape.kind == "line") lines.push_back(shape);
  REQUIRE(lines.size() == 2);
  for (const auto& line : lines) CHECK(line.body == line.other);
  // The corner (0.1, 0.1) of the wheel, turned by a quarter.
  CHECK(lines[0].at.norm() == Approx(0).margin(1e-15));
  CHECK((lines[0].more - Vec2{-0.1, 0.1}).norm() == Approx(0).margin(1e-15));
  // From the crank's only corner.
  CHECK((lines[1].at - Vec2{0.6, 0}).norm() == Approx(0).margin(1e-15));
  CHECK((lines[1].more - Vec2{0.5, 0.2}).norm() == Approx(0).margin(1e-15));
}
