#include "dynamics/assembly/assembly.hpp"

#include "dynamics/system.hpp"
#include "verification/support/rig.hpp"

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

/// The start of a scene of these elements, and the notes on what it assumes.
State start_of(const std::string& elements, std::string* assumed = nullptr,
               RunOptions::Start from = RunOptions::Start::assembled) {
  return assemble(parse_scene(elements + test::run_for(1), "s.toml").mechanism, from, assumed);
}
}  // namespace

TEST_CASE("assembly from a rough start displaces bodies in inverse proportion to their mass", "[assembly]") {
  // Two free bodies whose points must coincide: the lighter one moves farther, in the ratio of the
  // masses.
  const State s = start_of(test::body("heavy", 3, 1, "position = [0, 0]\n") +
                           test::body("light", 1, 1, "position = [0.4, 0]\n") +
                           test::pin("j", "heavy", "light") + "[assembly]\napproximate = true\n");
  REQUIRE(s.q[0] == Approx(0.1).epsilon(1e-7));
  REQUIRE(s.q[3] == Approx(0.1).epsilon(1e-7));
}

TEST_CASE("a journal outside its bearing is moved just inside", "[assembly]") {
  auto scene = read_scene(test::scene_file("ring"));
  scene.mechanism.bodies[1].position = Vec2(5e-3, 0);
  scene.mechanism.assembly.approximate = true;
  const State s = assemble(scene.mechanism, RunOptions::Start::assembled);
  const System system(scene.mechanism);
  auto e = system.make_evaluation();
  system.place(0, s.q.data(), e);
  // An interior-point method ends inside the bound by its last barrier parameter (1e-11) over the
  // multiplier of the bound, which in these units is 1e-6: 1e-5 of c; the test allows ten times
  // that.
  REQUIRE(system.gap(0, s.q.data(), e) >= -1e-9 * 1e-3);
  REQUIRE(system.gap(0, s.q.data(), e) < 1e-4 * 1e-3);
}

// The first wheel is driven to 0.1013 rad; the second is between the flanks there, off their middle
// by half of the free angle, so it need not move. The weights of the masses are 1 to 1e-3.
TEST_CASE("a body that fits its position is not moved by the assembly of another", "[assembly]") {
  const double r1 = 0.0373, r2 = 0.0973, play = 3.36e-4, phase = 1.06, driven = 0.1013;
  const double free = 0.5 * play / (r2 * std::cos(20 * 3.141592653589793 / 180));
  const double angle = phase - driven * r1 / r2 + 0.5 * free;
  const State s =
      start_of("format = 2\n" + test::body("one", 1, 1) + test::pin("shaft", "ground", "one") +
               test::motor("motor", "shaft", 0.1, fmt::format("initial_angle = {}\n", driven)) +
               test::body("two", 1, 1e-3, fmt::format("position = [{}, 0]\nangle = {}\n", r1 + r2, angle)) +
               test::pin("second", "ground", "two", {r1 + r2, 0}) +
               test::gear("mesh", "one", "two", {r1, r2},
                          fmt::format("phase = {}\nbacklash = {}\nmesh_stiffness = 4000\nsurface = \"s\"\n",
                                      phase, play)) +
               test::surface("s", 1, "young = 2e11\npoisson = 0.3\n"));
  CHECK(std::abs(s.q[2] - driven) < 1e-14);
  CHECK(std::abs(s.q[5] - angle) < 1e-14);
}

TEST_CASE("contradicting drives are refused", "[assembly]") {
  CHECK_THROWS_WITH(
      start_of(test::body("wheel", 1, 0.01) + test::pin("axle", "ground", "wheel") +
               test::drive("a", "axle", "speed_rpm = 10\n") + test::drive("b", "axle", "speed_rpm = 20\n")),
      Contains("contradict"));
}

TEST_CASE("a mechanism with clearance and no given velocities starts with those of the ideal mechanism",
          "[assembly]") {
  // clearance in the pin between coupler and rocker
  auto scene = read_scene(test::scene_file("four_bar"));
  std::string assumed;
  const State s = assemble(scene.mechanism, RunOptions::Start::assembled, &assumed);
  CHECK_THAT(assumed, Contains("no velocity is given") && Contains("the velocities of the ideal mechanism"));
  // Freudenstein: ω₄ = ω₂ (a/c) sin(θ₂ − θ₃)/sin(θ₄ − θ₃), ω₃ = ω₂ (a/b) sin(θ₂ − θ₄)/sin(θ₄ − θ₃)
  // with the signs of these scenes' angles: the rocker's frame points from its pivot to the pin. A
  // journal 0.2 mm off in bars of 100 mm and more turns angles by 2e-3, and the quotients by some
  // 1e-2.
  const double w2 = main_drive(scene.mechanism)->speed, t2 = s.q[2], t3 = s.q[5], t4 = s.q[8];
  const double w4 = w2 * 0.1 / 0.3 * std::sin(t2 - t3) / std::sin(t4 - t3);
  const double w3 = w2 * 0.1 / 0.35 * std::sin(t2 - t4) / std::sin(t4 - t3);
  CHECK(s.v[2] == Approx(w2).epsilon(1e-12));
  CHECK(s.v[5] == Approx(w3).epsilon(2e-2));
  CHECK(s.v[8] == Approx(w4).epsilon(2e-2));
  CHECK(largest_residual(System(scene.mechanism), s) < 1e-12);

  // Given velocities are changed as little as possible: the rocker, which no row connects with the
  // drive, stays at rest.
  scene.mechanism.bodies[0].angular_velocity = w2;
  const State given = assemble(scene.mechanism, RunOptions::Start::assembled, &assumed);
  CHECK_THAT(assumed, !Contains("no velocity"));
  CHECK(given.v[8] == 0);
  CHECK(given.v[2] == Approx(w2).epsilon(1e-12));

  // Nothing is assumed if the scene gives velocities, if no joint has clearance, or without a
  // drive.
  scene = read_scene(test::scene_file("four_bar"));
  assemble(scene.mechanism, RunOptions::Start::ideal, &assumed);
  CHECK_THAT(assumed, !Contains("no velocity"));
  assemble(idealised(scene.mechanism), RunOptions::Start::assembled, &assumed);
  CHECK_THAT(assumed, !Contains("no velocity"));
  scene.mechanism.drives.clear();
  const State still = assemble(scene.mechanism, RunOptions::Start::assembled, &assumed);
  CHECK_THAT(assumed, !Contains("no velocity"));
  for (const double v : still.v) CHECK(v == 0);
}

TEST_CASE(
    "if its ideal mechanism cannot move, a mechanism with clearance starts with the velocities of the drive",
    "[assembly]") {
  // Two driven cranks on one axle line, and a link that is too short for both pins at once except
  // for their clearance.
  std::string assumed;
  const State s =
      start_of(test::body("crank", 1, 0.01, "position = [0.05, 0]\n") +
                   test::body("link", 1, 0.01, "position = [0.2, 0]\n") +
                   test::pin("axle", "ground", "crank", {0, 0}, {-0.05, 0}) +
                   test::pin("pin", "crank", "link", {0.05, 0}, {-0.1, 0}, test::loose(1e-3, 1e-2)) +
                   test::pin("anchor", "ground", "link", {0.3005, 0}, {0.1, 0}) + test::surface("s", 0.5) +
                   test::motor("motor", "axle", 10),
               &assumed);
  CHECK_THAT(assumed, Contains("the ideal mechanism cannot move"));
  CHECK(s.v[2] == Approx(10));
  CHECK(s.v[5] == 0);
}

TEST_CASE("absent velocities are free and stated ones are kept", "[assembly]") {
  const auto start = [&](const std::string& keys, std::string* assumed = nullptr) {
    return start_of(test::pin("o", "ground", "p", {0, 0}, {0, 1}) + test::body("p", 1, 0.01, keys), assumed);
  };
  // ω = 2 rad/s about a pivot 1 m above the centre: v = 2 m/s along x.
  for (const char* keys : {"angular_velocity = 2\n", "velocity = [2, 0]\n"}) {
    std::string assumed;
    const State s = start(keys, &assumed);
    CHECK(s.v[2] == Approx(2).epsilon(1e-14));
    CHECK(s.v[0] == Approx(2).epsilon(1e-14));
    CHECK(std::abs(s.v[1]) < 1e-14);
    CHECK(assumed.empty());
  }
  // A contradiction names values, joint and residual; a small one is noted with its amount.
  CHECK_THROWS_WITH(start("angular_velocity = 2\nvelocity = [1, 0]\n"),
                    Contains("bodies.p") && Contains("joints.o (open by 1 m/s)") && Contains("approximate"));
  CHECK_THROWS_WITH(start("angle = 0.5\nposition = [0, -1]\n"),
                    Contains("bodies.p.position") && Contains("joints.o (open by") && Contains(" m)"));
  std::string assumed;
  start("angular_velocity = 2\nvelocity = [2.000002, 0]\n", &assumed);
  CHECK_THAT(assumed, Contains("bodies.p.angular_velocity by 1.98") && Contains("joints.o"));
  start("angular_velocity = 2\nvelocity = [2.0000000000001, 0]\n", &assumed);
  CHECK(assumed.empty());
  CHECK_NOTHROW(start("angular_velocity = 2\nvelocity = [1, 0]\n[assembly]\napproximate = true\n", &assumed));
  CHECK_THAT(assumed, Contains("bodies.p.angular_velocity"));
}

TEST_CASE("a start beyond a stop is refused unless the scene allows its change", "[assembly]") {
  const std::string text = test::body("p", 1, 0.01, "angle = \"50 deg\"\n") + test::pin("o", "ground", "p") +
                           test::stop("stop", "angle-stop", "o", "upper = \"30 deg\"\nradius = 0.1\n") +
                           test::surface("s", 0.5);
  CHECK_THROWS_WITH(start_of(text), Contains("bodies.p.angle by 0.3491 rad") &&
                                        Contains("contacts.stop.upper (overlaps by 0.03491 m)"));
  std::string assumed;
  CHECK(start_of(text + "[assembly]\napproximate = true\n", &assumed).q[2] == Approx(M_PI / 6).epsilon(1e-5));
  CHECK_THAT(assumed, Contains("bodies.p.angle by 0.3491 rad"));
}

// cos(π/2) of a harmonic velocity is 6e-17, not 0: its scale is the greatest rate of the drive.
TEST_CASE("a start from rest fits a drive whose rate is zero up to rounding", "[assembly]") {
  for (const char* stated : {"", "velocity = [0, 0]\nangular_velocity = 0\n"})
    for (const auto from :
         {RunOptions::Start::given, RunOptions::Start::assembled, RunOptions::Start::ideal}) {
      std::string assumed;
      const State s =
          start_of(test::body("belt", 1, 1, stated) + test::guide("guide", "ground", "belt") +
                       test::harmonic("vb", 2, 50) + test::drive("belt", "guide", "velocity = \"vb\"\n"),
                   &assumed, from);
      CHECK(std::abs(s.v[0]) < 1e-15);
      CHECK(assumed.empty());
    }
}

TEST_CASE("a stated rate of rounding size beside rates of zero is no contradiction", "[assembly]") {
  // Of seed 881702: the guide keeps the angle, and the angular velocity is one of an earlier assembly.
  std::string note;
  const auto start = [&](const char* rate) {
    return start_of(test::body("m", 1, 1, fmt::format("angle = 0\nangular_velocity = {}\n", rate)) +
                        test::guide("g", "ground", "m"),
                    &note);
  };
  for (const char* rate : {"0", "1.1e-17", "-3e-16"}) {
    CHECK(start(rate).v[2] == 0);
    CHECK(note.empty());
  }
  CHECK_THROWS_WITH(start("1e-3"), Contains("bodies.m.angular_velocity") && Contains("joints.g"));
}

TEST_CASE("positions without angles that the first guess does not close are kept from another guess",
          "[assembly]") {
  // Of seed 881701: the rod's centre is stated; crank and slider follow in one of two ways each.
  const Vec2 slider{-0.52513667117560792, 0.46359031104203097},
      on_guide{9.1901717995501286, -2.0117125087809957};
  const auto text = test::body("crank", 0.217, 0.2) + test::body("slider", 3.66, 2) +
                    test::body("rod", 0.33, 0.72, "position = [7.536248147200598, 0.24712145910770822]\n") +
                    test::pin("main", "crank", "ground", {0.42495699360271721, -0.45143916008777596},
                              {5.7648461334454524, 0.12514142343342258}) +
                    test::pin("pin", "rod", "crank", {-0.17971739625434346, -0.80811929769286173},
                              {-0.8526733971141528, 0.78829209766936847}) +
                    test::pin("gudgeon", "slider", "rod", slider, {-3.3631301367673521, 3.9813278936360348}) +
                    test::guide("guide", "ground", "slider", {0.65559425695877283, -0.75511334926795892},
                                on_guide, slider) +
                    test::run_for(1);
  const auto m = parse_scene(text, "crank").mechanism;
  for (const auto from : {RunOptions::Start::given, RunOptions::Start::assembled}) {
    std::string note;
    const auto start = assemble(m, from, &note);
    CHECK(start.q[6] == Approx(7.536248147200598).epsilon(1e-14));
    CHECK(start.q[7] == Approx(0.24712145910770822).epsilon(1e-13));
    CHECK(note.find("initial guess") != std::string::npos);
    const System system(m);
    CHECK(worst_open_joint(system, start.q).amount < 1e-13);
  }
}
