// Cams against geometry and finite differences: gaps of profiles with known gaps, contact rows and
// their rates, the bound that excludes a contact within a step, lift laws, and refused profiles.
#include "dynamics/system.hpp"
#include "io/scene/read_scene.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;

namespace {

constexpr double s = 1e-5;

/// Two bodies joined by a cam contact; `keys` are those of the contact.
Scene pair_of(const std::string& keys, const std::string& bodies = "\"cam\", \"follower\"") {
  return parse_scene(test::body("cam", 1, 1) + test::body("follower", 1, 1, "position = [0.0, 5.0]\n") +
                         test::surface("steel", 0.5, "young = 2e11\npoisson = 0.3\nfriction = 0.1\n") +
                         "[contacts.lobe]\ntype = \"cam\"\nbetween = [" + bodies + R"(]
at = [[0.1, -0.2], [0.3, 0.15]]
surface = "steel"
)" + keys + "\n" + test::run_for(1),
                     "cam");
}
const std::string law =
    "base_radius = 1.0\nlaw = \"cycloidal\"\nlift = 0.3\nstart = 0.4\nrise = 1.9\ndwell = 0.4\n"
    "return = 2.2\n";
const std::string flat = "axis = [-0.8, 0.6]\n", roller = "follower = \"roller\"\nroller_radius = 0.4\n";
const std::string eccentric =
    "base_radius = 1.0\nlaw = \"harmonic\"\nlift = 0.5\nstart = 0.4\nrise = 3.14159265358979312\n"
    "return = 3.14159265358979312\n";

struct Random {
  std::mt19937 engine{20260607};
  double operator()(double size) { return std::uniform_real_distribution<double>{-size, size}(engine); }
  std::vector<double> vector(int n, double size = 1) {
    std::vector<double> x(static_cast<std::size_t>(n));
    for (auto& y : x) y = (*this)(size);
    return x;
  }
  /// Poses of both bodies with their points about `apart` from each other.
  std::vector<double> pose(double apart) {
    auto q = vector(6, 3);
    const double to = (*this)(M_PI);
    const Vec2 at =
        Placement{q.data()}.point(0, {0.1, -0.2}) + Vec2{apart * std::cos(to), apart * std::sin(to)};
    q[3] = q[4] = 0;
    const Vec2 arm = Placement{q.data()}.point(1, {0.3, 0.15});
    q[3] = at.x() - arm.x(), q[4] = at.y() - arm.y();
    return q;
  }
};

std::vector<double> along(std::vector<double> q, const std::vector<double>& v, double t) {
  for (std::size_t i = 0; i < q.size(); ++i) q[i] += t * v[i];
  return q;
}

}  // namespace

TEST_CASE("the gap of a flat face on an eccentric cam is that of a circle's tangent", "[cam]") {
  const System system(pair_of(flat + eccentric).mechanism);
  auto e = system.make_evaluation();
  Random random;
  for (int trial = 0; trial < 200; ++trial) {
    const auto q = random.pose(1.5);
    system.place(0, q.data(), e);
    // h = 1/4 (1 − cos(ψ − start)): a disc of radius 1.25 about a centre 0.25 behind the cam's
    // point.
    const Placement placed{q.data()};
    const Vec2 centre = placed.point(0, Vec2{0.1, -0.2} - 0.25 * Vec2{std::cos(0.4), std::sin(0.4)});
    const Vec2 axis = placed.point(1, {-0.8, 0.6}) - placed.point(1, {0, 0});
    const double away = dot(-perp(axis), placed.point(1, {0.3, 0.15}) - centre);
    REQUIRE(system.gap(0, q.data(), e) == Approx(away - 1.25).margin(1e-12));
  }
}

TEST_CASE("contact rows of cams agree with finite differences, and their gap bound holds", "[cam]") {
  for (const auto& keys : {flat + law, roller + law, flat + eccentric}) {
    for (const char* bodies : {"\"cam\", \"follower\"", "\"ground\", \"follower\"", "\"cam\", \"ground\""}) {
      CAPTURE(keys, bodies);
      const System system(pair_of(keys, bodies).mechanism);
      auto e = system.make_evaluation(), lo = e, hi = e;
      ContactRow row, row_lo, row_hi;
      Random random;
      for (int trial = 0; trial < 50; ++trial) {
        auto q = random.pose(1.6);
        const bool both =
            system.contact_facts(0).bodies[0] != ground && system.contact_facts(0).bodies[1] != ground;
        if (!both) {  // about the ground's point
          const int body = system.contact_facts(0).bodies[0] == ground ? 1 : 0;
          const double to = random(M_PI), away = 1.7 + random(0.1);
          const Vec2 arm = body == 1 ? Vec2{0.3, 0.15} : Vec2{0.1, -0.2},
                     other = body == 1 ? Vec2{0.1, -0.2} : Vec2{0.3, 0.15};
          q[3 * body] = q[3 * body + 1] = 0;
          const Vec2 at =
              other + away * Vec2{std::cos(to), std::sin(to)} - Placement{q.data()}.point(body, arm);
          q[3 * body] = at.x(), q[3 * body + 1] = at.y();
        }
        const auto v = random.vector(6), a = random.vector(6);
        system.place(0, q.data(), e);
        const auto qa = along(q, v, -s), qb = along(q, v, s);
        system.place(0, qa.data(), lo);
        system.place(0, qb.data(), hi);
        system.contact(0, q.data(), v.data(), e, row);
        system.contact(0, qa.data(), v.data(), lo, row_lo);
        system.contact(0, qb.data(), v.data(), hi, row_hi);
        REQUIRE(row.gap == system.gap(0, q.data(), e));
        REQUIRE(row.normal.dot(v.data()) == Approx((row_hi.gap - row_lo.gap) / (2 * s)).margin(1e-7));
        REQUIRE(row.gamma_n ==
                Approx(-(row_hi.normal.dot(v.data()) - row_lo.normal.dot(v.data())) / (2 * s)).margin(1e-5));
        REQUIRE(
            row.gamma_t ==
            Approx(-(row_hi.tangent.dot(v.data()) - row_lo.tangent.dot(v.data())) / (2 * s)).margin(1e-5));
        // g̈ at an instant, with accelerations within the bounds.
        MotionBounds bounds;
        for (std::size_t i = 0; i < 6; ++i) {
          bounds.speed.push_back(std::abs(v[i]));
          bounds.acceleration.push_back(std::abs(a[i]));
        }
        const auto motion = system.gap_motion(0, bounds, q.data(), e);
        REQUIRE(std::abs(row.normal.dot(a.data()) - row.gamma_n) <= motion.acceleration);
        if (!both) continue;
        // Rotating both bodies about one point moves neither surface along the other, nor away.
        std::vector<double> common(6);
        for (int b : {0, 1}) {
          common[3 * b] = 0.3 - 0.7 * q[3 * b + 1];
          common[3 * b + 1] = -0.2 + 0.7 * q[3 * b];
          common[3 * b + 2] = 0.7;
        }
        REQUIRE(row.normal.dot(common.data()) == Approx(0).margin(1e-12));
        REQUIRE(row.tangent.dot(common.data()) == Approx(0).margin(1e-12));
      }
    }
  }
}

TEST_CASE("lift laws have the published heights, velocities and peak accelerations", "[cam]") {
  // Norton, Cam Design and Manufacturing Handbook: peak accelerations of 4.93, 6.28 and 5.77 L/β².
  const struct {
    CamLaw law;
    double speed, acceleration;
  } known[] = {{CamLaw::harmonic, M_PI / 2, M_PI * M_PI / 2},
               {CamLaw::cycloidal, 2, 2 * M_PI},
               {CamLaw::polynomial, 1.875, 10 / std::sqrt(3.0)}};
  for (const auto& k : known) {
    const double L = 0.02, rise = 1.2, fall = 0.8;
    const auto p = CamProfile::standard(k.law, L, 0.5, rise, 0.6, fall);
    CHECK(p.at(0.5).h == Approx(0).margin(1e-15));
    CHECK(p.at(0.5 + 0.5 * rise).h == Approx(0.5 * L));
    CHECK(p.at(0.5 + rise + 0.3).h == Approx(L));
    CHECK(p.at(0.5 + rise + 0.6 + 0.5 * fall - 2 * M_PI).h == Approx(0.5 * L));
    CHECK(p.at(0.4 + 8 * M_PI).h == Approx(0).margin(1e-15));
    double speed = 0, acceleration = 0;
    p.each([&](double, const CamProfile::Value& y) {
      speed = std::max(speed, std::abs(y.d1));
      acceleration = std::max(acceleration, std::abs(y.d2));
    });
    CHECK(speed == Approx(k.speed * L / fall).epsilon(1e-5));
    CHECK(acceleration == Approx(k.acceleration * L / (fall * fall)).epsilon(1e-4));
    CHECK(p.bounds().d1 >= speed);
    CHECK(p.bounds().d2 >= acceleration);
    CHECK(p.bounds().d2 <= 1.1 * acceleration);
    for (double phi = 0; phi < 6.3; phi += 0.0173) {
      const auto y = p.at(phi), a = p.at(phi - s), b = p.at(phi + s);
      CHECK(y.d1 == Approx((b.h - a.h) / (2 * s)).margin(1e-8));
      if (k.law != CamLaw::harmonic) CHECK(y.d2 == Approx((b.d1 - a.d1) / (2 * s)).margin(1e-5));
    }
  }
}

TEST_CASE("the spline of a lift table passes through its points and is smooth and periodic", "[cam]") {
  const std::vector<std::pair<double, double>> points{
      {-0.3, 0.01}, {0.4, 0.03}, {1.9, 0.02}, {4.0, 0.0}, {5.0, 0.004}};
  const auto p = CamProfile::through(points);
  for (const auto& [phi, h] : points) {
    for (const double turns : {0.0, 2 * M_PI, -4 * M_PI})
      CHECK(p.at(phi + turns).h == Approx(h).margin(1e-14));
    const auto before = p.at(phi - 1e-9), after = p.at(phi + 1e-9);
    CHECK(before.d1 == Approx(after.d1).margin(1e-9));
    CHECK(before.d2 == Approx(after.d2).margin(1e-8));
  }
}

TEST_CASE("cam profiles that cannot be made are refused with the reason", "[cam][scene]") {
  const auto refused = [](const std::string& keys, const std::string& why) {
    CAPTURE(keys);
    CHECK_THAT(test::refusal_of<SceneError>([&] { pair_of(keys); }), Catch::Contains(why));
  };
  const std::string steep = "law = \"cycloidal\"\nlift = 0.3\nrise = 1.0\nreturn = 1.0\n";
  refused("base_radius = 0.2\n" + steep, "a flat face cannot follow");
  refused(roller + "base_radius = 0.2\n" + steep, "undercut");
  refused("base_radius = 1\nlift_table = [[0, 0], [1, 0.1]]\n", "three points");
  refused("base_radius = 1\nlift_table = [[0, 0], [3, 0.1], [6.283185307179586, 0]]\n", "within one turn");
  refused("base_radius = 1\nlift_table = [[0, 0], [3, -2], [5, 0]]\n", "below the cam's point");
  refused("base_radius = 1\nlift_table = [[0, 0], [3, 0.1], [2, 0]]\n", "must increase");
  refused("base_radius = 1\nlift = 0.1\nlift_table = [[0, 0], [3, 0.1], [5, 0]]\n",
          "cannot be combined with lift_table");
  refused("base_radius = 1\nlift = 0.1\nrise = 4\nreturn = 3\n", "must fit into a turn");
  refused("base_radius = 1\nlift = 0.1\nrise = 1\n", "return: is missing");
  refused(flat + roller + law, "is of a flat follower");
  refused("roller_radius = 0.1\n" + law, "is of a roller");
  refused(law + "follower = \"knife\"\n", "follower");
}
