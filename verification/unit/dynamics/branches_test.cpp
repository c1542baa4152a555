// Assembly of a mechanism: four-bar loops and Grashof's types, the required branch, and starts that
// are not a pose.
#include "dynamics/assembly/assembly.hpp"
#include "dynamics/assembly/four_bar.hpp"
#include "dynamics/system.hpp"
#include "io/scene/write_scene.hpp"
#include "verification/references/four_bar_pose.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;
using Catch::Matchers::Contains;

namespace {

/// Links of these lengths, the middle of each body its centre of mass; no positions.
std::string four_bar(double d, double a, double b, double c, const std::string& more = "") {
  const auto link = [](const char* name, double length) { return test::body(name, 1, length * length / 12); };
  return link("crank", a) + link("coupler", b) + link("rocker", c) +
         test::pin("A", "ground", "crank", {}, {-a / 2, 0}) +
         test::pin("B", "crank", "coupler", {a / 2, 0}, {-b / 2, 0}) +
         test::pin("C", "coupler", "rocker", {b / 2, 0}, {c / 2, 0}) +
         test::pin("D", "ground", "rocker", {d, 0}, {-c / 2, 0}) + test::run_for(1) + more;
}

std::string drive(double angle) {
  return test::motor("motor", "A", 1, fmt::format("initial_angle = {}\n", angle));
}

std::string on_branch(bool open) {
  return fmt::format("[assembly]\nbranch = \"{}\"\n", open ? "open" : "crossed");
}

double from(double angle, double other) { return std::abs(std::remainder(angle - other, 2 * M_PI)); }

std::string message(const std::string& text) {
  return test::refusal_of([&] {
    const auto scene = parse_scene(text, "s.toml");
    assemble(scene.mechanism, scene.run.start);
  });
}

}  // namespace

TEST_CASE("Grashof types agree with the triangle inequality for all integer link lengths",
          "[assembly][grashof]") {
  int types[6] = {};
  for (int d = 1; d <= 7; ++d)
    for (int a = 1; a <= 7; ++a)
      for (int b = 1; b <= 7; ++b)
        for (int c = 1; c <= 7; ++c) {
          const FourBar loop{{}, {}, {double(d), double(a), double(b), double(c)}};
          const auto type = type_of(loop);
          ++types[static_cast<int>(type)];
          CAPTURE(d, a, b, c, static_cast<int>(type));
          const int longest = std::max({d, a, b, c}), sum = a + b + c + d;
          REQUIRE((type == Grashof::unclosable) == (longest > sum - longest));
          if (type == Grashof::unclosable || type == Grashof::change_point) continue;
          const auto [crank, rocker, on_crank, on_rocker] = reference::turns_fully(d, a, b, c);
          REQUIRE((type == Grashof::crank_rocker) == (crank != rocker));
          REQUIRE((type == Grashof::double_crank) == (crank && rocker));
          REQUIRE((type == Grashof::double_rocker) == (!crank && !rocker && on_crank && on_rocker));
          REQUIRE((type == Grashof::triple_rocker) == (!crank && !rocker && !on_crank && !on_rocker));
        }
  for (const int count : types) CHECK(count > 0);
}

TEST_CASE("a four-bar whose shortest and longest links are as long as the others is a change point",
          "[assembly][grashof]") {
  const auto type = [](double d, double a, double b, double c) { return type_of({{}, {}, {d, a, b, c}}); };
  CHECK(type(40, 30, 70, 60) == Grashof::change_point);
  CHECK(type(1, 1, 1, 1) == Grashof::change_point);
  CHECK(type(0.1, 0.2, 0.3, 0.2 + 1e-12) == Grashof::change_point);
}

TEST_CASE("four-bar loops are found, with the ground as fixed link and the driven link as input",
          "[assembly][grashof]") {
  const auto loop = [](const std::string& more) {
    const auto scene = parse_scene(four_bar(7, 2, 6, 5, more), "s.toml");
    const auto all = four_bars(scene.mechanism);
    REQUIRE(all.size() == 1);
    return all[0];
  };
  CHECK(loop("").lengths == std::array<double, 4>{7, 2, 6, 5});
  CHECK(loop("").joints == std::array{0, 1, 2, 3});
  const auto driven_at_d = loop(test::motor("m", "D", 1));
  CHECK(driven_at_d.lengths == std::array<double, 4>{7, 5, 6, 2});
  CHECK(driven_at_d.bodies == std::array{ground, 2, 1, 0});
  // Two loops with a common rocker; a slider-crank has none.
  CHECK(four_bars(test::row_of_four_bars(2, 0).mechanism).size() == 2);
  CHECK(four_bars(read_scene(test::flores()).mechanism).empty());
  CHECK(four_bars(read_scene(test::scene_file("seven_body")).mechanism).size() == 3);
}

TEST_CASE("both branches of a four-bar agree with the closed form, without given positions",
          "[assembly][branch]") {
  struct Links {
    double d, a, b, c;
  };
  for (const auto& [d, a, b, c] :
       {Links{0.4, 0.1, 0.35, 0.3}, {0.1, 0.3, 0.35, 0.3}, {7, 2, 6, 5}, {4e-6, 1e-6, 3.5e-6, 3e-6}})
    for (const double angle : {0.2, 1.0, 1.5, 2.2, 3.0})
      for (const bool open : {true, false}) {
        CAPTURE(d, a, angle, open);
        const auto scene = parse_scene(four_bar(d, a, b, c, drive(angle) + on_branch(open)), "s.toml");
        const auto s = assemble(scene.mechanism, scene.run.start);
        const auto exact = reference::four_bar_pose(d, a, b, c, angle, open);
        // Positions are closed to rounding; the error of angles is greater by at most 1/sin of the
        // transmission angle, here below 20.
        CHECK(from(s.q[2], angle) < 1e-12);
        CHECK(from(s.q[5], exact.coupler) < 1e-9);
        CHECK(from(s.q[8], exact.rocker) < 1e-9);
        CHECK((openness(scene.mechanism, four_bars(scene.mechanism)[0], s.q) > 0) == open);
      }
}

TEST_CASE("a mirrored four-bar stays open or crossed", "[assembly][branch]") {
  for (const bool open : {true, false}) {
    const auto scene = parse_scene(four_bar(0.4, 0.1, 0.35, 0.3, drive(-1.0) + on_branch(open)), "s.toml");
    const auto s = assemble(scene.mechanism, scene.run.start);
    CHECK(from(s.q[8], -reference::four_bar_pose(0.4, 0.1, 0.35, 0.3, 1.0, open).rocker) < 1e-9);
  }
}

TEST_CASE("the sign of a named angle selects a pose in any mechanism", "[assembly][branch]") {
  for (const bool positive : {true, false}) {
    const auto ask = fmt::format("[assembly]\n{} = [\"B-C-D\"]\n", positive ? "positive" : "negative");
    const auto scene = parse_scene(four_bar(0.4, 0.1, 0.35, 0.3, drive(1) + ask), "s.toml");
    const auto s = assemble(scene.mechanism, scene.run.start);
    CHECK((sine_of(scene.mechanism, {{1, 2, 3}}, s.q) > 0) == positive);
    // The request is in the canonical text; without a request nothing is.
    CHECK_THAT(to_toml(scene), Contains(ask));
    CHECK(same_facts(parse_scene(to_toml(scene), "again"), scene));
    // A slider-crank: the slider to the right of the pin, or to the left.
    const auto slider =
        read_scene(test::flores(), {"drives.motor.initial_angle=90 deg", "run.start=ideal",
                                    positive ? "assembly.negative=[\"main-big_end-gudgeon\"]"
                                             : "assembly.positive=[\"main-big_end-gudgeon\"]"});
    const auto placed = assemble(slider.mechanism, slider.run.start);
    const double x = std::sqrt(0.3 * 0.3 - 0.05 * 0.05);
    CHECK(placed.q[6] == Approx(positive ? -x : x).epsilon(1e-12));
  }
  CHECK_THAT(to_toml(parse_scene(four_bar(0.4, 0.1, 0.35, 0.3), "s.toml")), !Contains("[assembly]"));
}

TEST_CASE("requests of [assembly] that cannot be met or read are refused by their key",
          "[assembly][errors]") {
  const auto with = [](const std::string& ask) {
    return message(four_bar(0.4, 0.1, 0.35, 0.3, drive(1) + "[assembly]\n" + ask));
  };
  CHECK(with("branch = \"open\"\n") == "accepted");
  CHECK_THAT(with("positive = [\"B-C-D\"]\nnegative = [\"B-C-D\"]\n"),
             Contains("assembly.") && Contains("angle B-C-D is") && Contains("other initial guesses"));
  test::check_messages(with, {{"positive = [\"B-C-X\"]\n", "\"B-C-X\" is not an angle A-B-C at joint B"},
                              {"positive = [\"B-B-C\"]\n", "is not an angle"},
                              {"branch = \"wide\"\n", "assembly.branch: \"wide\" is unknown"},
                              {"braanch = \"open\"\n", "is not a key of [assembly]; did you mean branch?"}});
}

TEST_CASE("assembly.branch requires exactly one four-bar loop", "[assembly][errors]") {
  const auto flores = [](const std::string& set) {
    const auto scene = read_scene(test::flores(), {set});
    return assemble(scene.mechanism, scene.run.start);
  };
  CHECK_THROWS_WITH(flores("assembly.branch=open"),
                    Contains("exactly one four-bar loop") && Contains("there is none"));
  auto row = test::row_of_four_bars(2, 0);
  row.mechanism.assembly.branch = Configuration::Branch::open;
  CHECK_THROWS_WITH(assemble(row.mechanism, RunOptions::Start::assembled), Contains("there are 2"));
}

TEST_CASE("joint names of an angle may contain -", "[assembly]") {
  const auto text = four_bar(0.4, 0.1, 0.35, 0.3, drive(1) + "[assembly]\npositive = [\"B-C-C-D\"]\n");
  CHECK_THAT(message(text), Contains("is not an angle"));  // the joints are A, B, C, D
  CHECK(message(test::replaced(text, "[joints.C]", "[joints.C-C]")) == "accepted");  // B, C-C, D
}

TEST_CASE("a loop with too long a link is refused with the excess", "[assembly][errors]") {
  // 0.9 − (0.1 + 0.35 + 0.3) = 0.15
  CHECK_THAT(
      message(four_bar(0.9, 0.1, 0.35, 0.3)),
      Contains("cannot be closed") && Contains("link ground of 0.9 m is 0.15 m longer than the other three"));
}

TEST_CASE("a start that fails to assemble is replaced by another, reported and reproducible one",
          "[assembly]") {
  // The given pose closes, but is not the requested one.
  std::string said, again;
  auto scene = parse_scene(four_bar(0.4, 0.1, 0.35, 0.3, drive(1) + on_branch(true)), "s.toml");
  start_from(scene.mechanism, assemble(scene.mechanism, scene.run.start));
  scene.mechanism.assembly.branch = Configuration::Branch::crossed;
  const auto s = assemble(scene.mechanism, scene.run.start, &said);
  CHECK_THAT(said, Contains("\"crossed\" is requested, but the pose found is open") &&
                       Contains("assembled from initial guess 1 of") &&
                       Contains("coupler and rocker mirrored"));
  CHECK(assemble(scene.mechanism, scene.run.start, &again).q == s.q);
  CHECK(again == said);
  // Without a request there is no message, and the pose near the given one is kept.
  auto plain = scene;
  plain.mechanism.assembly = {};
  assemble(plain.mechanism, plain.run.start, &said);
  CHECK(said.empty());
  // "given" is accepted as it is, or refused.
  auto given = scene;
  start_from(given.mechanism, s);
  given.mechanism.assembly.branch = Configuration::Branch::open;
  CHECK_THROWS_WITH(assemble(given.mechanism, RunOptions::Start::given),
                    Contains("assembly.branch: \"open\" is requested, but the pose found is crossed"));
}

TEST_CASE("mechanisms of several loops assemble without stated values", "[assembly]") {
  for (const auto* file : {"seven_body", "four_bar_two"}) {
    CAPTURE(file);
    auto scene = read_scene(test::scene_file(file));
    for (auto& body : scene.mechanism.bodies) {
      body.position.reset();
      body.angle.reset();
      body.velocity.reset();
      body.angular_velocity.reset();
    }
    const auto s = assemble(scene.mechanism, RunOptions::Start::ideal);
    CHECK(worst_open_joint(System(idealised(scene.mechanism)), s.q).amount < 1e-9);
  }
}

TEST_CASE("given angles without positions are kept: each body is placed on the one before it", "[assembly]") {
  // Two bars, at -30 and -110 degrees; only the angles are given.
  const auto text = [](double first, double second) {
    return test::body("upper", 1, 0.1, fmt::format("angle = {}\n", first)) +
           test::body("lower", 2, 0.1, fmt::format("angle = {}\n", second)) +
           test::pin("pivot", "ground", "upper", {1, 2}, {-0.15, 0}) +
           test::pin("elbow", "lower", "upper", {-0.125, 0.01}, {0.15, 0}) + test::run_for(1);
  };
  const double a = -M_PI / 6, b = -110 * M_PI / 180;
  const auto scene = parse_scene(text(a, b), "s.toml");
  const auto s = assemble(scene.mechanism, scene.run.start);
  CHECK(s.q[2] == a);
  CHECK(s.q[5] == b);
  CHECK(s.q[0] == Approx(1 + 0.15 * std::cos(a)).epsilon(1e-15));
  CHECK(s.q[3] == Approx(1 + 0.3 * std::cos(a) + 0.125 * std::cos(b) + 0.01 * std::sin(b)).epsilon(1e-14));
  // Given whole revolutions are kept too: they would act on a torsional spring.
  const auto wound = parse_scene(text(a + 4 * M_PI, b), "s.toml");
  CHECK(assemble(wound.mechanism, wound.run.start).q[2] == Approx(a + 4 * M_PI).epsilon(1e-14));
  // Where they contradict a position, the least displacement decides.
  const auto placed =
      parse_scene(text(a, b), "s.toml", {"bodies.upper.position=[1.1, 2]", "assembly.approximate=true"});
  CHECK(std::abs(assemble(placed.mechanism, placed.run.start).q[2] - a) > 1e-3);
}
