// Point bodies and rods against closed forms, in both formulations and every scheme; and elements
// that are refused on a point body.
#include "dynamics/assembly/assembly.hpp"
#include "dynamics/assembly/equilibrium.hpp"
#include "dynamics/assembly/modes.hpp"
#include "dynamics/system.hpp"
#include "verification/references/pendulum.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;
using Catch::Matchers::Contains;
using Catch::Matchers::StartsWith;
using test::point, test::rod;

namespace {

/// A method, and its permitted error (m, m/s) in a second of motion of about a metre.
struct Method {
  test::Way way;
  double bound;
};

/// Tolerances of 1e-10 accumulate over some hundred steps: 1e-7. Moreau–Jean is of second order in
/// smooth motion with steps of 1e-4 s and accelerations of 10 m/s²: a speed error of 1e-8 a step,
/// at most 1e-4 in 1 s.
const std::vector<Method> methods{
    {{"penalty", Family::penalty, {}, 0, {"penalty.tolerance=1e-10"}}, 1e-6},
    {{"event-driven", Family::nonsmooth, Scheme::event_driven, 0, {"nonsmooth.tolerance=1e-10"}}, 1e-6},
    {{"automatic", Family::nonsmooth, Scheme::automatic, 0, {"nonsmooth.tolerance=1e-10"}}, 1e-6},
    {test::fixed_steps(1e-4), 1e-3}};

State end_of(const std::string& text, const test::Way& way, double duration) {
  return test::finished(way, text, {fmt::format("run.duration={}", duration)}).final_state;
}

constexpr double g = 9.81;

const std::string heavy = "gravity = [0, -9.81]\n", any = "[run]\nduration = 1\n";
const std::string smooth = "[surfaces.smooth]\nyoung = 2e11\npoisson = 0.3\nrestitution = 1\n";

}  // namespace

TEST_CASE("a point mass on a spring to the ground moves on an ellipse", "[points]") {
  const double k = 35, m = 0.7, A = 0.4, B = 0.15, rate = std::sqrt(k / m);
  const auto text =
      point("ball", A, 0, m, {0, B * rate}) + test::spring("spring", "ground", "ball", {}, {}, k, 0) + any;
  for (const auto& [way, bound] : methods) {
    INFO(way.name);
    const auto s = end_of(text, way, 1);
    CHECK(std::abs(s.q[0] - A * std::cos(rate)) <= bound);
    CHECK(std::abs(s.q[1] - B * std::sin(rate)) <= bound);
    CHECK(s.q[2] == 0);
    CHECK(s.v[2] == 0);
  }
}

// Newton's and Coulomb's laws at each impact: e = 0.8, and the first impact takes μ(1 + e) v from
// the sliding speed.
TEST_CASE("a thrown point mass bounces on a floor with friction", "[points]") {
  const double h = 0.5, e = 0.8, mu = 0.1, vx = 3;
  const auto text = heavy + point("ball", 0, h, 0.7, {vx, 0}) +
                    test::plane("floor", "ground", "ball", 0, "rough", "axis = [1, 0]\n") +
                    test::surface("rough", e, mu) + any;
  const double v = std::sqrt(2 * g * h), first = std::sqrt(2 * h / g), second = first + 2 * e * v / g;
  for (const auto& [way, bound] : methods) {
    if (way.penalty()) continue;  // no stiffness is given
    INFO(way.name);
    const auto run = test::finished(way, text);
    REQUIRE(run.events.size() >= 2);
    const double late = way.fixed() ? 2e-4 : 1e-9,
                 off = way.fixed() ? 5e-3 : 1e-8;  // two steps; the effect of gravity in them
    CHECK(std::abs(run.events[0].t - first) <= late);
    CHECK(std::abs(run.events[1].t - second) <= 2 * late);
    CHECK(std::abs(run.events[0].v_n_plus - e * v) <= off);
    CHECK(std::abs(run.events[0].v_t_plus - (vx - mu * (1 + e) * v)) <= off);
  }
}

// The first ball swings down in a quarter of its period and transfers its whole momentum to the
// second, which continues as a single pendulum would.
TEST_CASE("a cradle of two point masses transfers its momentum", "[points]") {
  const double L = 0.8, R = 0.01, amplitude = 0.4;
  const reference::Pendulum pendulum{0.7, 0, L, g, -amplitude};
  const double quarter = pendulum_period(pendulum) / 4, t = 1.7 * quarter;
  const auto text = heavy + smooth + point("left", -L * std::sin(amplitude), -L * std::cos(amplitude)) +
                    point("right", 2 * R, -L) + rod("one", "ground", "left", L) +
                    rod("two", "ground", "right", L) + fmt::format("at = [[{}, 0], [0, 0]]\n", 2 * R) +
                    test::discs("balls", "left", "right", R, R, "smooth") + any;
  for (const auto& [way, bound] : methods) {
    // Steps and elastic contacts cause a delay by their duration; the impact is instantaneous only
    // in event-driven runs.
    if (way.penalty() || way.fixed()) continue;
    INFO(way.name);
    const auto s = end_of(text, way, t);
    const auto expected = pendulum_state(pendulum, t);
    CHECK(std::abs(s.q[3] - 2 * R - L * std::sin(expected.angle)) <= 1e-5);
    CHECK(std::abs(s.q[0]) <= 1e-5);
    CHECK(std::abs(s.v[0]) <= 1e-5);
  }
}

// With K = 2e5 N/m and no damping the contact lasts half a period, π √(m/K), with a depth of v
// √(m/K); F = K δ.
TEST_CASE("a corner contact with a given stiffness has the duration and depth of its spring (penalty)",
          "[points][penalty]") {
  const double m = 0.7, v = 1.2, K = 2e5;
  for (const double e : {1.0, 0.6}) {
    INFO("restitution " << e);
    const auto text =
        point("ball", 0.1, 0.3, m, {0, -v}) +
        test::plane("wall", "ground", "ball", 0, "s", fmt::format("axis = [1, 0]\nstiffness = {}\n", K)) +
        test::surface("s", e) + "[penalty]\ncontact = \"exact\"\n" + any;
    const auto run = test::finished(methods[0].way, text);
    REQUIRE(run.events.size() == 1);
    CHECK(run.events[0].v_n_plus == Approx(e * v).epsilon(1e-6));
    CHECK(run.events[0].impulse_n == Approx((1 + e) * m * v).epsilon(1e-6));
    if (e < 1) continue;
    CHECK(run.events[0].duration == Approx(std::numbers::pi * std::sqrt(m / K)).epsilon(1e-6));
    CHECK(run.extremes.penetration[0] == Approx(v * std::sqrt(m / K)).epsilon(1e-6));
    CHECK(std::abs(run.ledger.closure()) <= 1e-8 * 0.5 * m * v * v);
  }
}

TEST_CASE("check counts two coordinates for a point body", "[points]") {
  const test::TemporaryFolder folder;
  const auto file = folder.path() / "double.toml";
  std::ofstream(file) << heavy + point("upper", 0.8, 0) + point("lower", 1.3, 0) +
                             rod("first", "ground", "upper", 0.8) + rod("second", "upper", "lower", 0.5) +
                             any;
  const auto o = test::succeeded("check " + file.string());
  CHECK_THAT(o.out, Contains("bodies                      2, 2 of them without rotation") &&
                        Contains("coordinates                 4\n") &&
                        Contains("constraint rows             2 (") &&
                        Contains("degrees of freedom          2\n") &&
                        Contains("mobility                    2 = 3n - p"));
}

TEST_CASE("small vibrations of point bodies have the frequencies of the closed form and no rotation",
          "[points]") {
  const double L = 0.8;
  const auto one =
      parse_scene(heavy + point("bob", 0, -L) + rod("string", "ground", "bob", L) + any, "one.toml");
  const System system(one.mechanism);
  const auto start = assemble(one.mechanism, one.run.start);
  const auto modes = find_modes(system, find_equilibrium(one.mechanism, system, start.q, {}), {}).modes;
  REQUIRE(modes.size() == 1);
  CHECK(modes[0].natural() == Approx(std::sqrt(g / L) / (2 * std::numbers::pi)).epsilon(1e-9));
}

TEST_CASE("an element that turns a point body or acts off its centre is refused at its key", "[points]") {
  const auto bodies = point("p", 0.5, 0) + test::body("r", 1, 0.1) +
                      test::surface("rough", 0.5, 0.2, "young = 2e11\npoisson = 0.3\n") + any;
  const std::string pin = "[joints.pin]\ntype = \"revolute\"\nbetween = [\"r\", \"p\"]\n";
  struct Case {
    std::string added, said;
  };
  for (const auto& [added, said] : std::vector<Case>{
           {pin + "at = [[0, 0], [0.5, 0]]\n", "joints.pin.at: must be [0, 0] on \"p\""},
           {pin + test::loose(1e-3, 0.01, "rough"),
            "joints.pin.surface: has friction with a couple on \"p\""},
           {test::guide("guide", "ground", "p"), "joints.guide.between: acts on the angle of \"p\""},
           {"[joints.weld]\ntype = \"rigid\"\nbetween = [\"r\", \"p\"]\n",
            "joints.weld.between: acts on the angle of \"p\""},
           {"[joints.slot]\ntype = \"slot\"\nbetween = [\"p\", \"r\"]\n",
            "joints.slot.between: the slot is on the first body"},
           {test::plane("floor", "ground", "p", 0.1, "rough"),
            "contacts.floor.surface: has friction with a couple on \"p\""},
           {test::discs("two", "r", "p", 0.1, 0.1, "rough"),
            "contacts.two.surface: has friction with a couple on \"p\""},
           {pin + test::motor("motor", "pin", 3), "drives.motor.joint: acts on the angle of \"p\""},
           {"[loads.twist]\ntype = \"torque\"\nbody = \"p\"\ntorque = 3\n",
            "loads.twist.body: acts on the angle of \"p\""},
           {"[loads.push]\ntype = \"force\"\nbody = \"p\"\nforce = [1, 0]\nat = [0.1, 0]\n",
            "loads.push.at: must be [0, 0] on \"p\""},
           {"[loads.push]\ntype = \"force\"\nbody = \"p\"\nforce = [1, 0]\naxes = \"body\"\n",
            "loads.push.axes: must be \"world\""},
           {test::torsion("coil", "r", "p", 3), "loads.coil.between: acts on the angle of \"p\""},
           {test::spring("spring", "r", "p", {}, {0, 0.1}, 3, 0), "loads.spring.at: must be [0, 0] on \"p\""},
           {"[loads.mount]\ntype = \"bushing\"\nbetween = [\"r\", \"p\"]\nstiffness = [3, 3]\n"
            "torsional_stiffness = 1\n",
            "loads.mount.torsional_stiffness: acts on the angle of \"p\""},
           {pin +
                "[instruments.encoder]\ntype = \"encoder\"\njoint = \"pin\"\ncounts = 360\nsampling = 1000\n",
            "instruments.encoder.joint: has no angle"},
       }) {
    INFO(added);
    CHECK_THAT(test::refusal(bodies + added), StartsWith("s.toml:") && Contains(said));
  }
  for (const auto* key : {"inertia = 1", "angle = 0.1", "angular_velocity = 2", "points = { a = [0, 0] }"}) {
    INFO(key);
    const auto text = fmt::format("[bodies.p]\nmass = 1\npoint = true\n{}\n", key) + any;
    REQUIRE_THROWS_WITH(parse_scene(text, "s.toml"),
                        StartsWith("s.toml:4:") && Contains("needs a body with rotation"));
  }
}
