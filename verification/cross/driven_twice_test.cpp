// Constraints that say the same twice run where the motion is determined; the works of drives at chosen steps; a spring
// whose length passes through zero; kinks against a speed. Each by every way, against closed forms.
#include <catch2/catch.hpp>
#include <cmath>

#include "mechanism/scene.hpp"
#include "verification/support/support.hpp"

using namespace freeplay;
using Catch::Matchers::Contains;

namespace {

struct By {
  const char* name;
  Family family;
  std::vector<std::string> options;
  bool fixed = false;
};
By every_way() {
  return GENERATE(By{"penalty", Family::penalty, {}},
                  By{"event-driven", Family::nonsmooth, {"nonsmooth.scheme=\"event-driven\""}},
                  By{"chosen steps",
                     Family::nonsmooth,
                     {"nonsmooth.scheme=\"moreau-jean\"", "nonsmooth.step=\"automatic\""}},
                  By{"moreau-jean",
                     Family::nonsmooth,
                     {"nonsmooth.scheme=\"moreau-jean\"", "nonsmooth.step=1e-4"},
                     true});
}

Result finished(const std::string& text, const By& by, std::vector<std::string> more = {}) {
  auto options = by.options;
  options.insert(options.end(), more.begin(), more.end());
  const auto run = test::simulate(parse_scene(text, "s.toml", options), by.family);
  CAPTURE(run.ending.reason);
  REQUIRE(run.ending.status == Ending::Status::finished);
  return run;
}
bool doubtful(const Result& run) {
  return std::ranges::any_of(run.notes, [](const auto& note) { return note.starts_with("DOUBTFUL"); });
}

/// Two ideal wheels of 0.1 m and 0.2 m in mesh, both driven: the second at `second` rad/s.
std::string two_motors(double second, const std::string& more = "") {
  return "format = 2\n[bodies.a]\nmass = 1\ninertia = 0.01\n[bodies.b]\nmass = 2\ninertia = 0.04\n"
         "position = [0.3, 0]\n"
         "[joints.pa]\ntype = \"revolute\"\nbetween = [\"ground\", \"a\"]\n"
         "[joints.pb]\ntype = \"revolute\"\nbetween = [\"ground\", \"b\"]\nat = [[0.3, 0], [0, 0]]\n"
         "[joints.mesh]\ntype = \"gear\"\nbetween = [\"a\", \"b\"]\npitch_radii = [0.1, 0.2]\n"
         "[drives.first]\njoint = \"pa\"\nspeed = 10\n[drives.second]\njoint = \"pb\"\nspeed = " +
         std::to_string(second) + "\n" + more + "[run]\nduration = 1\n";
}

const std::string slider =
    "format = 2\n[bodies.b]\nmass = 2\ninertia = 0.01\n"
    "[joints.guide]\ntype = \"translational\"\nbetween = [\"ground\", \"b\"]\n";

}  // namespace

TEST_CASE("two drives that agree over ideal gears turn, loaded or not, and the rest is told",
          "[twice][drives]") {
  const auto by = every_way();
  const bool loaded = GENERATE(false, true);
  CAPTURE(by.name, loaded);
  const auto run = finished(
      two_motors(-5, loaded ? "[loads.brake]\ntype = \"torque\"\nbody = \"b\"\ntorque = 3\n" : ""), by);
  // θ = ω t to a thousand roundings of 10 rad; nothing accelerates, so both drives together do what the brake takes.
  CHECK(run.final_state.q[2] == Approx(10).epsilon(1e-12));
  CHECK(run.final_state.q[5] == Approx(-5).epsilon(1e-12));
  CHECK(run.ledger.drive == Approx(loaded ? 15 : 0).margin(1e-9));
  CHECK(
      std::ranges::any_of(run.notes, [](const auto& n) { return n.find("depend on each other") != n.npos; }));
  CHECK_FALSE(doubtful(run));
}

TEST_CASE("two drives that contradict each other over gears are refused where they are read",
          "[twice][errors]") {
  const auto by = every_way();
  CHECK_THROWS_WITH(test::simulate(parse_scene(two_motors(-6), "s.toml", by.options), by.family),
                    Contains("no velocities satisfy all constraints"));
}

TEST_CASE("chosen steps book what a drive does as its work", "[chosen][drives]") {
  const By by{"chosen steps",
              Family::nonsmooth,
              {"nonsmooth.scheme=\"moreau-jean\"", "nonsmooth.step=\"automatic\""}};
  SECTION("a body lifted along a curve: work is the change of energy, whatever the step") {
    // m g s with s = 0.05 m amid the dwell of the third period; its speed is 0 there. To rounding: steps are exact.
    const auto run = finished(
        "format = 2\ngravity = [0, -9.81]\n[bodies.b]\nmass = 2\ninertia = 0.01\n"
        "[joints.g]\ntype = \"translational\"\nbetween = [\"ground\", \"b\"]\naxis = [0, 1]\n"
        "[drives.m]\njoint = \"g\"\nposition = \"lift\"\n[curves.lift]\nshape = \"rise-dwell-return\"\nto = 0.05\n"
        "rise = 0.4\ndwell = 0.1\nreturn = 0.3\nrest = 0.2\nprofile = \"cycloidal\"\nrepeat = true\n"
        "[run]\nduration = 2.45\n",
        by);
    CHECK(run.ledger.drive == Approx(2 * 9.81 * 0.05).epsilon(1e-9));
    CHECK(std::abs(run.ledger.stabilisation) <= 1e-9);
    CHECK_FALSE(doubtful(run));
  }
  SECTION("a body that comes back to rest where it began: nothing is left to be doubtful of") {
    for (const auto& way :
         {By{"penalty", Family::penalty, {}},
          By{"event-driven", Family::nonsmooth, {"nonsmooth.scheme=\"event-driven\""}}, by}) {
      CAPTURE(way.name);
      CHECK_FALSE(doubtful(finished(
          "format = 2\n[bodies.b]\nmass = 2\ninertia = 0.01\n"
          "[joints.g]\ntype = \"translational\"\nbetween = [\"ground\", \"b\"]\n"
          "[drives.m]\njoint = \"g\"\nposition = \"lift\"\n[curves.lift]\nshape = \"rise-dwell-return\"\nto = 0.05\n"
          "rise = 0.4\ndwell = 0.1\nreturn = 0.3\nrest = 0.2\nprofile = \"cycloidal\"\nrepeat = true\n"
          "[run]\nduration = 3\n",
          way)));
    }
  }
  SECTION("a slider-crank at a constant speed: work is the change of kinetic energy") {
    const std::string text =
        "format = 2\n[bodies.crank]\nmass = 1\ninertia = 0.01\n[bodies.rod]\nmass = 1\ninertia = 0.03\n"
        "[bodies.slider]\nmass = 2\ninertia = 0.01\n"
        "[joints.a]\ntype = \"revolute\"\nbetween = [\"ground\", \"crank\"]\n"
        "[joints.b]\ntype = \"revolute\"\nbetween = [\"crank\", \"rod\"]\nat = [[0.1, 0], [-0.2, 0]]\n"
        "[joints.c]\ntype = \"revolute\"\nbetween = [\"rod\", \"slider\"]\nat = [[0.2, 0], [0, 0]]\n"
        "[joints.g]\ntype = \"translational\"\nbetween = [\"ground\", \"slider\"]\n"
        "[drives.m]\njoint = \"a\"\nspeed = 50\n[run]\nduration = 1\n";
    const auto energy = [](double angle) {
      const double w = 50, sine = -0.25 * std::sin(angle), cosine = std::sqrt(1 - sine * sine);
      const double turning = -0.25 * w * std::cos(angle) / cosine;
      const double x = -0.1 * w * std::sin(angle) - 0.2 * turning * sine,
                   y = 0.1 * w * std::cos(angle) + 0.2 * turning * cosine;
      const double slide = -0.1 * w * std::sin(angle) - 0.4 * turning * sine;
      return 0.5 * (0.01 * w * w + x * x + y * y + 0.03 * turning * turning + 2 * slide * slide);
    };
    const auto run = finished(text, by);
    // Two hundred steps of 1e-6 of the speed each: 4e-4 of the energies. A thousandth is what a run tells of itself.
    CHECK(run.ledger.drive == Approx(energy(50) - energy(0)).margin(4e-4 * energy(0)));
    CHECK(std::abs(run.ledger.stabilisation) <= 4e-4 * energy(0));
    CHECK_FALSE(doubtful(run));
  }
}

TEST_CASE("a spring that a free slider takes through zero length turns round there", "[twice][springs]") {
  // m ẍ = −k (|x| − L) sgn x, from rest at L + A: harmonic about ±L either side, with ω = √(k/m). From L + A to 0 it
  // takes t₁ = (π/2 + asin(L/A))/ω, and by symmetry 2 t₁ to rest at −(L + A), 4 t₁ back to the start.
  const auto by = every_way();
  const double L = GENERATE(0.0, 0.1), A = 0.25, k = 50, m = 2, w = std::sqrt(k / m);
  const double t1 = (std::acos(-1) / 2 + std::asin(L / A)) / w;
  CAPTURE(by.name, L);
  const auto at = [&](double t) {
    return finished(
               slider +
                   "[loads.spring]\ntype = \"spring-damper\"\nbetween = [\"ground\", \"b\"]\nstiffness = 50\n"
                   "free_length = " +
                   std::to_string(L) + "\n[run]\nduration = 1\n",
               by,
               {"bodies.b.position=[" + std::to_string(L + A) + ", 0]", "run.duration=" + std::to_string(t)})
        .final_state;
  };
  // Half way between 0 and the far end, and a full period later. Tolerances of 1e-9 (chosen 1e-6) times some hundred steps; a
  // fixed step's middle lies up to h/2 beside the place, where the force jumps by 2 k L: v is off by up to k L h/m a pass,
  // and x by that over 1/ω more.
  const double h = 1e-4, far = 2 * k * L * h / m / w;
  const double bound = by.fixed            ? 3 * far + 0.25 * w * w * h * h * 10
                       : by.name[0] == 'c' ? 1e-4 * A
                                           : 1e-6 * A;
  const double late = 1.5 * t1;
  const double x = -(L + A * std::cos(w * (2 * t1 - late)));
  CHECK(at(late).q[0] == Approx(x).margin(bound));
  const auto back = at(4 * t1);
  CHECK(back.q[0] == Approx(L + A).margin(3 * bound));
  CHECK(back.v[0] == Approx(0).margin(3 * w * bound + 1e-5));
}

TEST_CASE("a kink of a damper's table against the speed costs no way its order", "[twice][springs]") {
  // m v̇ = −D(v), D = 1 v up to 1 m/s, then 1 + 9 (v − 1): from 3 m/s exponential to v = 1, v + (…) of rate 9/m about
  // v₀ = 8/9, at T = (m/9) ln((3 − 8/9)/(1/9)), then exp(−(t − T)/m).
  const auto by = every_way();
  CAPTURE(by.name);
  const double m = 2, T = m / 9 * std::log((3 - 8.0 / 9) * 9);
  const double end = 1.5;
  REQUIRE(T < end);
  const auto text =
      slider +
      "[loads.damper]\ntype = \"spring-damper\"\nbetween = [\"ground\", \"b\"]\nat = [[-10, 0], [0, 0]]\n"
      "damping_table = [[-2, -10], [-1, -1], [0, 0], [1, 1], [2, 10]]\n[run]\nduration = 1.5\n";
  const double v = std::exp(-(end - T) / m);
  const auto off = [&](std::vector<std::string> more) {
    more.emplace_back("bodies.b.velocity=[3, 0]");
    return std::abs(finished(text, by, more).final_state.v[0] - v);
  };
  if (!by.fixed) {  // a thousand steps of tolerance 1e-9 (chosen 1e-6)
    CHECK(off({}) <= (by.name[0] == 'c' ? 1e-3 : 1e-6));
    return;
  }
  // Of second order on average: the place of the kink within its step is by chance, so over a factor of 16 together, within one.
  const double coarse = off({"nonsmooth.step=1.6e-2"}), fine = off({"nonsmooth.step=1e-3"});
  const double order = std::log(coarse / fine) / std::log(16.0);
  CHECK(order > 1.5);
  CHECK(order < 2.6);
}
