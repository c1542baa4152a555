#include "model/assembly.hpp"

#include <catch2/catch.hpp>

#include "model/scene.hpp"
#include "model/system.hpp"
#include "verification/support.hpp"

using namespace freeplay;
using Catch::Matchers::Contains;

namespace {
double largest_residual(const System& system, const State& s) {
  auto e = system.make_evaluation();
  system.place(0, s.q.data(), e);
  double worst = 0;
  for (int k = 0; k < system.rows(); ++k) {
    worst = std::max(worst, std::abs(e.phi[k]));
    worst = std::max(worst, std::abs(row_dot(system.pattern(), e.G.data(), k, s.v.data()) + e.phi_t[k]));
  }
  return worst;
}
}  // namespace

TEST_CASE("the reference scene assembles from no positions at all", "[assembly]") {
  const auto scene = read_scene(test::flores());
  const State s = assemble(scene.mechanism, RunOptions::Start::ideal);
  const System ideal(idealised(scene.mechanism));
  REQUIRE(largest_residual(ideal, s) < 1e-13);
  // Ideal slider-crank at top dead centre: rod's centre at r + l/2, slider at r + l, rod turning at −ω r/l.
  const double omega = main_drive(scene.mechanism)->speed;
  REQUIRE(s.q[3] == Approx(0.2));
  REQUIRE(s.q[6] == Approx(0.35));
  REQUIRE(s.v[5] == Approx(-omega * 0.05 / 0.3));
  REQUIRE(s.v[6] == Approx(0).margin(1e-14));
}

TEST_CASE("a rough start moves as little as the masses say", "[assembly]") {
  // Two free bodies whose points must meet: the lighter one moves farther, in the ratio of the masses.
  const auto scene = parse_scene(R"(
[bodies.heavy]
mass = 3
inertia = 1
[bodies.light]
mass = 1
inertia = 1
position = [0.4, 0]
[joints.j]
type = "revolute"
between = ["heavy", "light"]
[run]
duration = 1
)",
                                 "two");
  const State s = assemble(scene.mechanism, RunOptions::Start::assembled);
  REQUIRE(s.q[0] == Approx(0.1).epsilon(1e-7));
  REQUIRE(s.q[3] == Approx(0.1).epsilon(1e-7));
}

TEST_CASE("a journal outside its bearing is moved just inside", "[assembly]") {
  auto scene = read_scene(test::scene_file("ring"));
  scene.mechanism.bodies[1].position = Vec2(5e-3, 0);
  const State s = assemble(scene.mechanism, RunOptions::Start::assembled);
  const System system(scene.mechanism);
  auto e = system.make_evaluation();
  system.place(0, s.q.data(), e);
  // An interior-point method ends inside by its last barrier parameter (1e-11) over the multiplier of the
  // bound, which in these units is 1e-6: 1e-5 of c; allow ten times that.
  REQUIRE(system.gap(0, s.q.data(), e) >= -1e-9 * 1e-3);
  REQUIRE(system.gap(0, s.q.data(), e) < 1e-4 * 1e-3);
}

TEST_CASE("four-bars from rough positions, and undriven at a position of their own", "[assembly]") {
  for (const auto* name : {"four_bar", "four_bar_two", "double_pendulum", "big_end"}) {
    const auto scene = read_scene(test::scene_file(name));
    const State s = assemble(scene.mechanism, scene.run.start);
    CAPTURE(name);
    REQUIRE(largest_residual(System(idealised(scene.mechanism)), s) < 1e-12);
  }
}

TEST_CASE("what cannot be assembled is refused with the joint and the distance", "[assembly]") {
  // A rod of 0.3 m between a pivot and a point 1 m away: 0.7 m are missing.
  const auto scene = parse_scene(R"(
[bodies.rod]
mass = 1
inertia = 0.01
[joints.left]
type = "revolute"
between = ["ground", "rod"]
at = [[0, 0], [-0.15, 0]]
[joints.right]
type = "revolute"
between = ["ground", "rod"]
at = [[1, 0], [0.15, 0]]
[run]
duration = 1
)",
                                 "short");
  try {
    assemble(scene.mechanism, RunOptions::Start::assembled);
    FAIL("assembled");
  } catch (const ModelError& e) {
    CHECK_THAT(e.what(), Contains("cannot be assembled") && Contains("stays open by 0."));
    CHECK_THAT(e.what(), Contains("\"left\"") || Contains("\"right\""));
  }
}

TEST_CASE("contradicting drives are refused", "[assembly]") {
  const auto scene = parse_scene(R"(
[bodies.wheel]
mass = 1
inertia = 0.01
[joints.axle]
type = "revolute"
between = ["ground", "wheel"]
[drives.a]
joint = "axle"
speed_rpm = 10
[drives.b]
joint = "axle"
speed_rpm = 20
[run]
duration = 1
)",
                                 "drives");
  REQUIRE_THROWS_WITH(assemble(scene.mechanism, RunOptions::Start::assembled), Contains("contradict"));
}

TEST_CASE("a given start is taken as it stands, or refused", "[assembly]") {
  auto scene = read_scene(test::scene_file("double_pendulum"));
  REQUIRE_NOTHROW(assemble(scene.mechanism, RunOptions::Start::given));
  scene.mechanism.bodies[0].position.x() += 1e-3;
  REQUIRE_THROWS_WITH(assemble(scene.mechanism, RunOptions::Start::given), Contains("stays open by 0.001 m"));
}
