// Points of a body by name, in a frame chosen by the author.
#include "io/scene/write_scene.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;
using Catch::Matchers::Contains;

namespace {

std::string scene(const std::string& points, const std::string& at, const std::string& load_at = "[0.2, 0]") {
  return test::body("rod", 1, 0.1) + points + "\n" +
         test::body("mate", 1, 0.1, "points = { hole = [-0.25, 0.1] }\n") +
         "[joints.pin]\ntype = \"revolute\"\nbetween = [\"rod\", \"mate\"]\nat = " + at + "\n" +
         test::force("push", "rod", {1, 0}, "at = " + load_at + "\n") + test::run_for(1);
}
const std::string named = "points = { A = [0, 0], B = [\"300 mm\", 0.05], mass_centre = [0.12, 0.01] }";

}  // namespace

TEST_CASE("named points give the same scene as their coordinates, bit for bit", "[points][scene]") {
  // 0.3 − 0.12 and the like are rounded as in the reader.
  const double x = 0.3 - 0.12, y = 0.05 - 0.01;
  const auto by_name = parse_scene(scene(named, "[\"B\", \"hole\"]", "\"A\""), "s.toml");
  auto by_numbers = parse_scene(scene("", "[[1, 2], [-0.25, 0.1]]"), "s.toml");
  std::get<RevoluteJoint>(by_numbers.mechanism.joints[0]).at[0] = {x, y};
  std::get<ForceLoad>(by_numbers.mechanism.loads[0]).at = {-0.12, -0.01};
  CHECK(to_toml(by_name) == to_toml(by_numbers));
  CHECK(to_toml(parse_scene(to_toml(by_name), "again")) == to_toml(by_name));
  // Mixed, and one point moved on the command line.
  const auto mixed = parse_scene(scene(named, "[\"B\", [-0.25, 0.1]]"), "s.toml");
  CHECK(std::get<RevoluteJoint>(mixed.mechanism.joints[0]).at ==
        std::get<RevoluteJoint>(by_name.mechanism.joints[0]).at);
  const auto moved = parse_scene(scene(named, "[\"B\", \"hole\"]"), "s.toml", {"bodies.rod.points.B=[1, 0]"});
  CHECK(std::get<RevoluteJoint>(moved.mechanism.joints[0]).at[0] == Vec2{1 - 0.12, 0 - 0.01});
  // The centre of mass has its name, given or not, and is the origin of the stored points.
  for (const auto* points : {named.c_str(), "points = { B = [1, 2] }", ""}) {
    const auto centred = parse_scene(scene(points, "[\"mass_centre\", \"mass_centre\"]"), "s.toml");
    CHECK(std::get<RevoluteJoint>(centred.mechanism.joints[0]).at == std::array<Vec2, 2>{});
  }
  // A separate table, and without mass_centre: from the centre of mass.
  const auto table =
      parse_scene(scene("[bodies.rod.points]\nB = [0.18, 0.04]", "[\"B\", \"hole\"]"), "s.toml");
  CHECK(std::get<RevoluteJoint>(table.mechanism.joints[0]).at[0] == Vec2{0.18, 0.04});
}

TEST_CASE("an unknown point is refused with a list of the known ones", "[points][errors]") {
  const std::string at = "[\"B\", \"hole\"]";
  test::check_messages(
      [](const std::string& text) { return test::refusal(text); },
      {{scene(named, "[\"C\", \"hole\"]"),
        "s.toml:12:6: joints.pin.at: there is no point of bodies.rod \"C\"; there is: mass_centre, A, B"},
       {scene(named, "[\"hole\", \"B\"]"), "there is no point of bodies.rod \"hole\""},
       {scene("", "[\"A\", \"hole\"]"), "there is no point of bodies.rod \"A\""},
       {scene(named, "[\"B\", \"hole\", \"hole\"]"), "must be two points"},
       {scene(named, at, "\"D\""), "loads.push.at: there is no point"},
       {scene("points = 3", at), "bodies.rod.points: must be a table of points"},
       {scene("points = { B = 3 }", at), "bodies.rod.points.B: must be a pair [x, y], is a number"},
       {scene("points = { B = [\"1 kg\", 0] }", at),
        "bodies.rod.points.B: \"1 kg\" is a mass, must be a length"},
       {scene("points = { B = [1e300, 0] }", at), "must be at most 1e+09 m"},
       {scene("points = { \"a b\" = [1, 0] }", at), "a name must be made of letters"}});
  CHECK_THAT(test::refusal(scene(named, at), {"joints.pin.between=[\"ground\", \"mate\"]"}),
             Contains("the ground has no named points"));
}

TEST_CASE("points of the ground have names like those of bodies", "[points]") {
  // "hole" belongs to the other body, "wall" to the ground; both orders of the pair, the end of a
  // load too, and one moved on the command line.
  const auto text = [](const std::string& fixed, const std::string& at) {
    return fixed + test::body("rod", 1, 1) +
           "[joints.pin]\ntype = \"revolute\"\nbetween = [\"ground\", \"rod\"]\nat = " + at +
           "\n[loads.spring]\ntype = \"spring-damper\"\nbetween = [\"rod\", \"ground\"]\n"
           "at = [[0, 0], \"roof\"]\nstiffness = 1\n" +
           test::run_for(1);
  };
  const std::string fixed = "[ground]\npoints = { wall = [\"400 mm\", 0.1], roof = [0, 2] }\n";
  const auto by_name = parse_scene(text(fixed, "[\"wall\", [0, 0]]"), "s.toml");
  const auto& pin = std::get<RevoluteJoint>(by_name.mechanism.joints[0]);
  CHECK(pin.at[0] == Vec2{0.4, 0.1});
  CHECK(std::get<SpringDamper>(by_name.mechanism.loads[0]).at[1] == Vec2{0, 2});
  CHECK(to_toml(parse_scene(to_toml(by_name), "again")) == to_toml(by_name));
  const auto moved = parse_scene(text(fixed, "[\"wall\", [0, 0]]"), "s.toml", {"ground.points.wall=[1, 0]"});
  CHECK(std::get<RevoluteJoint>(moved.mechanism.joints[0]).at[0] == Vec2{1, 0});
  const std::string wall = "[\"wall\", [0, 0]]";
  test::check_messages(
      [](const std::string& scene) { return test::refusal(scene); },
      {{text(fixed, "[\"wal\", [0, 0]]"), "there is no point of the ground \"wal\""},
       {text(fixed, "[\"wal\", [0, 0]]"), "wall"},
       {text("", wall), "the ground has no named points"},
       {text("", wall), "points = { \"wall\" = [x, y] }"},
       {text("[ground]\npoints = { wall = 3 }\n", wall), "ground.points.wall: must be a pair [x, y]"},
       {text("[ground]\nmass = 3\n", wall), "ground.mass"}});
}
