// The System against finite differences: every element of the Jacobian, γ, gap rows and their second
// derivatives. Central differences of step s have errors of s² times third derivatives (here of order
// 1 to 100 in SI units) plus rounding ε/s; with s = 1e-5 both stay below 1e-7.
#include "dynamics/system.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;

namespace {

constexpr double s = 1e-5, bound = 1e-7;

/// A mechanism with pins, guides, a weld, rods, contacts and a drive, between moving bodies and to the
/// ground in either order.
Scene everything() {
  return parse_scene(
      "gravity = [0.3, -9.81]\n" + test::body("a", 1.5, 0.02) + test::body("b", 0.7, 0.01) +
          test::body("c", 2.0, 0.05) +
          test::surface("steel", 0.5, "young = 2e11\npoisson = 0.3\nfriction = 0.1\n") +
          test::pin("pin_ground", "ground", "a", {0.1, 0.2}, {0.3, -0.1}) +
          test::pin("pin", "a", "b", {-0.2, 0.1}, {0.15, 0.05}) +
          test::pin("pin_back", "c", "ground", {0.12, -0.07}, {0.5, 0.4}) +
          test::guide("slide", "b", "c", {0.6, 0.8}, {0.02, 0.03}, {-0.04, 0.05}, "angle = 0.2\n") +
          test::guide("guide", "ground", "b", {1.0, 0.3}, {0.1, 0.1}, {0.07, -0.02}) +
          test::joint("weld", "rigid", "a", "c", {0.2, 0.3}, {0.1, -0.2}, "angle = 0.4\n") +
          test::joint("rod", "rod", "b", "c", {0.2, 0.3}, {0.1, -0.2}, "length = 0.6\n") +
          test::joint("rod_ground", "rod", "ground", "a", {0.3, -0.1}, {}, "length = 0.9\n") +
          test::pin("loose", "a", "c", {0.11, 0.06}, {-0.13, 0.08}, test::loose(0.4, 0.5, "steel")) +
          test::pin("loose_ground", "ground", "b", {0.0, 0.1}, {0.2, 0.1}, test::loose(0.3, 0.6, "steel")) +
          test::guide("play", "b", "c", {0.8, -0.6}, {0.1, 0.2}, {-0.3, 0.1},
                      "angle = 0.3\nclearance = 0.1\nslider_length = 0.7\nslider_height = 0.4\n"
                      "surface = \"steel\"\n") +
          test::plane("wall", "a", "b", 0.15, "steel",
                      "at = [[0.3, 0.2], [-0.1, 0.4]]\naxis = [0.6, -0.8]\n") +
          test::discs("discs", "c", "a", 0.2, 0.5, "steel", "at = [[0.3, 0.2], [-0.1, 0.4]]\n") +
          test::drive("motor", "pin", "speed_rpm = 90\n") +
          test::joint_friction("rub", "slide", "force = 5\n") + test::run_for(1),
      "everything");
}

struct Random {
  std::mt19937 engine{20260101};
  std::uniform_real_distribution<double> uniform{-1, 1};
  std::vector<double> vector(int n) {
    std::vector<double> x(static_cast<std::size_t>(n));
    for (auto& y : x) y = uniform(engine);
    return x;
  }
};

std::vector<double> along(const std::vector<double>& q, const std::vector<double>& v, double t) {
  auto x = q;
  for (std::size_t i = 0; i < x.size(); ++i) x[i] += t * v[i];
  return x;
}

/// Random states q, v of the mechanism, and evaluations at q and at q ∓ s v.
struct Displaced {
  System system{everything().mechanism};
  Random random;
  std::vector<double> q, v, qa, qb;
  decltype(system.make_evaluation()) e = system.make_evaluation(), lo = e, hi = e;

  void next() {
    q = random.vector(system.n()), v = random.vector(system.n());
    qa = along(q, v, -s), qb = along(q, v, s);
    system.place(0, q.data(), e);
    system.place(-s, qa.data(), lo);
    system.place(s, qb.data(), hi);
  }
  /// Central difference of a row's product with v.
  template <class Row>
  double change(const Row& before, const Row& after) const {
    return (after.dot(v.data()) - before.dot(v.data())) / (2 * s);
  }
};

}  // namespace

TEST_CASE("every element of the constraint Jacobian equals its central difference", "[system]") {
  const System system(everything().mechanism);
  Random random;
  auto e = system.make_evaluation(), lo = e, hi = e;
  for (int trial = 0; trial < 20; ++trial) {
    const auto q = random.vector(system.n());
    const double t = 0.3 * trial;
    system.place(t, q.data(), e);
    for (int c = 0; c < system.n(); ++c) {
      auto qa = q, qb = q;
      qa[c] -= s;
      qb[c] += s;
      system.place(t, qa.data(), lo);
      system.place(t, qb.data(), hi);
      for (int k = 0; k < system.rows(); ++k) {
        double G = 0;
        for (int i = system.pattern().begin[k]; i < system.pattern().begin[k + 1]; ++i)
          if (system.pattern().column[i] == c) G += e.G[i];
        CAPTURE(system.row_name(k), c);
        REQUIRE(G == Approx((hi.phi[k] - lo.phi[k]) / (2 * s)).margin(bound));
      }
    }
    system.place(t - s, q.data(), lo);
    system.place(t + s, q.data(), hi);
    for (int k = 0; k < system.rows(); ++k)
      REQUIRE(e.phi_t[k] == Approx((hi.phi[k] - lo.phi[k]) / (2 * s)).margin(bound));
  }
}

TEST_CASE("gamma is the negative second derivative of the constraints at zero acceleration", "[system]") {
  // Along q + t v the acceleration is zero, so d(Gv + Φ_t)/dt = −γ.
  Displaced d;
  const auto& system = d.system;
  for (int trial = 0; trial < 20; ++trial) {
    d.next();
    system.rate(d.q.data(), d.v.data(), d.e);
    for (int k = 0; k < system.rows(); ++k) {
      const double rate_lo = row_dot(system.pattern(), d.lo.G.data(), k, d.v.data());
      const double rate_hi = row_dot(system.pattern(), d.hi.G.data(), k, d.v.data());
      CAPTURE(system.row_name(k));
      REQUIRE(d.e.gamma[k] == Approx(-(rate_hi - rate_lo) / (2 * s)).margin(bound));
    }
  }
}

TEST_CASE("contact rows of gap and sliding agree with finite differences, including rotation of the surfaces",
          "[system]") {
  Displaced d;
  const auto& [system, random, q, v, qa, qb, e, lo, hi] = d;
  ContactRow row, row_lo, row_hi;
  for (int trial = 0; trial < 20; ++trial) {
    d.next();
    for (int k = 0; k < system.contacts(); ++k) {
      const auto& facts = system.contact_facts(k);
      system.contact(k, q.data(), v.data(), e, row);
      system.contact(k, qa.data(), v.data(), lo, row_lo);
      system.contact(k, qb.data(), v.data(), hi, row_hi);
      REQUIRE(row.gap == system.gap(k, q.data(), e));
      REQUIRE(row.normal.dot(v.data()) == Approx((row_hi.gap - row_lo.gap) / (2 * s)).margin(bound));
      REQUIRE(row.gamma_n == Approx(-d.change(row_lo.normal, row_hi.normal)).margin(1e-6));
      REQUIRE(row.gamma_t == Approx(-d.change(row_lo.tangent, row_hi.tangent)).margin(1e-6));
      if (!facts.ring) continue;
      // Sliding: t·ė by differences of the eccentricity, plus the rotation of the surfaces.
      const Vec2 tangent = perp(system.eccentricity(k, q.data(), e).direction());
      const Vec2 rate =
          (system.eccentricity(k, qb.data(), hi) - system.eccentricity(k, qa.data(), lo)) / (2 * s);
      const auto omega = [&](int body) { return body == ground ? 0 : v[3 * body + 2]; };
      const double expected = dot(tangent, rate) + facts.radius_journal * omega(facts.bodies[1]) -
                              facts.radius_bearing * omega(facts.bodies[0]);
      REQUIRE(row.tangent.dot(v.data()) == Approx(expected).margin(bound));
    }
  }
}

TEST_CASE("sliding at walls and discs: zero in common motion, radius times spin of the second body",
          "[system]") {
  // Rotating both bodies about one point moves neither surface along the other in contact; across a
  // gap of discs it moves one surface past the other by gap × ω.
  const System system(everything().mechanism);
  Random random;
  auto e = system.make_evaluation();
  ContactRow row;
  const std::map<std::string, double> radius{{"wall", 0.15}, {"discs", -0.5}};
  for (int trial = 0; trial < 20; ++trial) {
    const auto q = random.vector(system.n()), x = random.vector(3);
    std::vector<double> common(system.n());
    for (int b = 0; b < system.bodies(); ++b) {
      common[3 * b] = x[0] - x[2] * q[3 * b + 1];
      common[3 * b + 1] = x[1] + x[2] * q[3 * b];
      common[3 * b + 2] = x[2];
    }
    system.place(0, q.data(), e);
    for (int k = 0; k < system.contacts(); ++k) {
      const auto& facts = system.contact_facts(k);
      if (facts.ring) continue;
      system.contact(k, q.data(), common.data(), e, row);
      const bool discs = facts.name == "discs";
      CAPTURE(facts.name);
      CHECK(row.normal.dot(common.data()) == Approx(0).margin(1e-12));
      CHECK(row.tangent.dot(common.data()) == Approx(discs ? row.gap * x[2] : 0).margin(1e-12));
      std::vector<double> turn(system.n());
      turn[3 * facts.bodies[1] + 2] = 1;
      if (radius.contains(facts.name)) {
        // The motion of the centre by the body's own rotation is compensated by moving the body
        // back.
        const Vec2 at{-0.1, 0.4};
        const double c = std::cos(q[3 * facts.bodies[1] + 2]), sn = std::sin(q[3 * facts.bodies[1] + 2]);
        turn[3 * facts.bodies[1]] = sn * at.x() + c * at.y();
        turn[3 * facts.bodies[1] + 1] = -(c * at.x() - sn * at.y());
        CHECK(row.tangent.dot(turn.data()) == Approx(radius.at(facts.name)).margin(1e-12));
      }
    }
  }
}

TEST_CASE("the sliding row of a preloaded joint and its second derivative", "[system]") {
  Displaced d;
  SparseRow row, row_lo, row_hi;
  for (int trial = 0; trial < 20; ++trial) {
    d.next();
    const double gamma = d.system.friction(0, d.q.data(), d.v.data(), d.e, row);
    d.system.friction(0, d.qa.data(), d.v.data(), d.lo, row_lo);
    d.system.friction(0, d.qb.data(), d.v.data(), d.hi, row_hi);
    REQUIRE(gamma == Approx(-d.change(row_lo, row_hi)).margin(1e-6));
  }
}

TEST_CASE("a journal at the centre of its bearing has no normal and no contact", "[system]") {
  const auto scene =
      parse_scene(test::body("a", 1, 1) + test::surface("s", 0.5) +
                      test::pin("j", "ground", "a", {}, {}, test::loose(1e-3, 1e-2)) + test::run_for(1),
                  "concentric");
  const System system(scene.mechanism);
  auto e = system.make_evaluation();
  const std::vector<double> zero(3, 0.0);
  ContactRow row;
  system.place(0, zero.data(), e);
  system.contact(0, zero.data(), zero.data(), e, row);
  REQUIRE(row.gap == 1e-3);
  REQUIRE(row.normal.size == 0);
}

namespace {

/// A small disc above a wall and another on a long arm above a second wall; `long_arm_first`
/// selects which contact is first.
Scene two_walls(bool long_arm_first) {
  const auto short_one = test::plane("short", "ground", "a", 0.01);
  const auto long_one = test::plane("long", "ground", "b", 0.02, "s", "at = [[0, -9], [3, 0]]\n");
  return parse_scene(test::body("a", 1, 1, "position = [0, 1]\n") + test::body("b", 1, 1) +
                         test::surface("s", 0.5) +
                         (long_arm_first ? long_one + short_one : short_one + long_one) +
                         test::spring("spring", "ground", "a", {}, {}, 10, 0) + test::run_for(1),
                     "walls");
}

}  // namespace

TEST_CASE("the reference length of a wall's penetration does not depend on the order of the contacts",
          "[system]") {
  // By hand: a thousandth of the longest lever arm, 3 m; the disc's radius would give 1e-5.
  for (const bool first : {true, false}) {
    const auto scene = two_walls(first);
    const System system(scene.mechanism);
    for (int k : {0, 1}) {
      CAPTURE(first, system.contact_facts(k).name);
      CHECK(system.contact_facts(k).clearance == Approx(3e-3).epsilon(1e-15));
    }
  }
}

TEST_CASE("each element states the rows that it adds to the solver, and their sum is the size of the system",
          "[system]") {
  const auto scene = read_scene(test::source_folder() / "cases/flores2011/scene.toml");
  const System system(scene.mechanism);
  int rows = 0, contacts = 0;
  for (const auto& c : system.carried()) {
    rows += c.rows;
    contacts += c.contacts;
    if (c.name == "gudgeon") CHECK((c.rows == 0 && c.contacts == 1 && c.kind == "revolute"));
    if (c.name == "guide") CHECK((c.rows == 2 && c.contacts == 0 && c.kind == "translational"));
    if (c.name == "motor") CHECK((c.rows == 1 && c.kind == "speed drive"));
  }
  CHECK(rows == system.rows());
  CHECK(contacts == system.contacts());
  const auto walls = two_walls(true);
  const System walled(walls.mechanism);
  const auto& last = walled.carried().back();
  CHECK((last.force && last.rows == 0));
}

TEST_CASE("the crank of a torque-driven mechanism is the joint of the first torque", "[system]") {
  const std::string text = test::body("crank", 1.0, 0.1) + test::body("arm", 1.0, 0.1) +
                           test::pin("main", "ground", "crank") +
                           test::pin("elbow", "crank", "arm", {1.0, 0.0}) + test::run_for(1.0) +
                           test::drive("first", "elbow", "torque = 1.0\n");
  const auto speed = test::motor("second", "main", 2);
  const std::vector<double> q{0, 0, 0.7, 1, 0, 0.9};
  CHECK(System(parse_scene(text, "torque").mechanism).crank_angle(q.data()) == Approx(0.2));
  CHECK(System(parse_scene(text + speed, "speed").mechanism).crank_angle(q.data()) == Approx(0.7));
}
