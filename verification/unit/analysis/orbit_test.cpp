// Periodic motions: refusals, a pendulum of unknown period, and multipliers of random scenes against
// central differences of the return map.
#include <cstddef>

#include "analysis/orbit.hpp"
#include "verification/claims/orbit_scenes.hpp"
#include "verification/references/orbits.hpp"
#include "verification/references/sensitivity.hpp"
#include "verification/support/rig.hpp"
#include "verification/unit/analysis/orbit_maps.hpp"

using namespace freeplay;
using Catch::Matchers::Contains;
using namespace verification::maps;

namespace {

std::string ball_on_table(const std::string& more = "") {
  return "gravity = [0, -9.81]\n" + test::body("table", 1, 0.01) +
         test::body("ball", 0.3, 3e-4, "position = [0, 0.08]\n") +
         test::guide("guide", "ground", "table", {0, 1}) + test::guide("rail", "ground", "ball", {0, 1}) +
         test::plane("pair", "table", "ball", 0.05, "hard") + test::surface("hard", 0.5) +
         shaker("guide", 3.2e-3, 0.1) + test::run_for(1) + event_driven + more;
}

void check_refused(const std::string& text, const OrbitRequest& request, const char* reason) {
  CHECK_THROWS_WITH(orbit(parse_scene(text, "s.toml"), request), Contains(reason));
}

const std::string pendulum = "gravity = [0, -9.81]\n" +
                             test::body("bar", 1, 0.01, "position = [0.2, 0]\nangle = 1.5707963267948966\n") +
                             test::pin("pivot", "ground", "bar", {0, 0}, {0, 0.2}) + test::run_for(1) +
                             event_driven;

}  // namespace

TEST_CASE("requests without a periodic motion are refused", "[orbit]") {
  const auto ball = ball_on_table();
  check_refused(ball, {.periods = 0}, "periods: must be 1 or greater");
  check_refused(ball, {.settle = -1}, "settle: must be 0 or greater");
  for (const double settle : {1e-308, 1e-320, 1e-18, 1e11, 1e308})
    check_refused(ball, {.settle = settle}, "settle: makes a duration of");
  check_refused(ball, {.period = 0.2}, "contradicts the drives, whose period is 0.1 s");
  check_refused(pendulum, {}, "nothing in the scene depends on time");
  // Two periods that have no common multiple among them.
  check_refused(ball_on_table(test::harmonic("push", 1, 0.07) +
                              test::drive("second", "rail", "force = \"push\"\nagainst = \"time\"\n")),
                {}, "periods of 0.1 s and 0.07 s");
  check_refused(test::body("crank", 1, 0.01) + test::pin("main", "ground", "crank") +
                    test::motor("motor", "main", 10) + test::run_for(1) + event_driven,
                {}, "no degrees of freedom");
}

TEST_CASE("searches without a periodic motion end with the reason", "[orbit]") {
  // Far from the periodic motion, no step reduces the residual.
  const auto far = orbit(parse_scene(ball_on_table(), "s.toml",
                                     {"curves.shake.amplitude=10e-3", "bodies.ball.position=[0, 0.09]"}),
                         {.settle = 0});
  CHECK_THAT(far.failure, Contains("Newton's method ends at a residual of"));
  CHECK(far.residual > 1e-6);
  const auto rest =
      orbit(parse_scene(pendulum, "s.toml", {"bodies.bar.position=[0, -0.2]", "bodies.bar.angle=0"}),
            {.settle = 0, .period = 1});
  CHECK_THAT(rest.failure, Contains("equilibrium"));
}

TEST_CASE("the section is moved away from an impact that falls on it", "[orbit]") {
  const reference::ShakenBall ball{3.5e-3L, 60, 9.81L, 0.5L};
  const auto scene = parse_scene(verification::scenes::shaken_ball(ball, 1e-3L, 5), "ball");
  for (const double beside : {0.0, 1e-9, -1e-9, 1e-4, -1e-4}) {
    INFO(beside);
    const auto found =
        orbit(scene, {.settle = static_cast<double>(ball.impact_time() / ball.period()) + beside});
    INFO(found.failure);
    REQUIRE(found.failure.empty());
    REQUIRE(found.impacts.size() == 1);
    CHECK(found.impacts[0].speed == Approx(static_cast<double>(ball.approach())).epsilon(1e-8));
    const auto product = found.multipliers.at(0) * found.multipliers.at(1);
    CHECK(product.real() == Approx(static_cast<double>(ball.determinant())).epsilon(1e-7));
  }
}

TEST_CASE("a ball that its table carries has no degree of freedom at the section", "[orbit]") {
  const auto found = orbit(parse_scene(ball_on_table(), "s.toml", {"curves.shake.amplitude=1e-3"}), {});
  CHECK(found.failure.empty());
  CHECK(found.multipliers.empty());
  CHECK(found.stable);
  CHECK(found.impacts.empty());
}

TEST_CASE("the period of a pendulum is found", "[orbit]") {
  const auto found = orbit(parse_scene(pendulum, "s.toml"), {.settle = 0, .period = 1.1});
  REQUIRE(found.failure.empty());
  // Swing to the angle at which the kinetic energy vanishes: T = 4 K(sin(θ/2))/ω, ω² = m g a/(J + m a²).
  const long double g = 9.81L, a = 0.2L, inertia = 0.01L + a * a;
  const long double rate = found.state.v[2], height = found.state.q[1] + inertia * rate * rate / (2 * g);
  const long double modulus = std::sqrt((1 + height / a) / 2);
  const long double expected = 4 * reference::CompleteElliptic(modulus).K / std::sqrt(g * a / inertia);
  CHECK(std::abs(found.period - static_cast<double>(expected)) < 1e-9);
  CHECK(found.multipliers.size() == 2);
  for (const auto& m : found.multipliers) CHECK(std::abs(m - 1.0) < 1e-4);  // a double one
  CHECK_FALSE(found.stable);
}

TEST_CASE("multipliers of random scenes equal those of differenced return maps", "[orbit]") {
  int compared[4] = {};
  double worst = 0;
  for (int i = 0; i < 40; ++i) {
    Draw r(20261126, i);
    const auto m = random_map(i, r);
    const auto scene = parse_scene(m.text, "random");
    const auto found = orbit(scene, {.settle = 20});
    CAPTURE(i, m.text, found.failure);
    if (!found.failure.empty() || (found.impacts.empty() && i % 4 < 3)) continue;
    const auto D = differenced(scene, "nonsmooth", m, found);
    REQUIRE(static_cast<Eigen::Index>(found.multipliers.size()) == D.rows());
    const double error = apart(found.multipliers, D);
    worst = std::max(worst, error);
    // Errors of the integration, 1e-12 a step, over displacements of 1e-5.
    CHECK(error < 1e-5);
    ++compared[i % 4];
  }
  WARN(fmt::format("{}, {}, {} and {} motions compared, greatest error {:.2g}", compared[0], compared[1],
                   compared[2], compared[3], worst));
  for (const int count : compared) CHECK(count >= 3);
}

TEST_CASE("multipliers of penalty motions equal those of differenced return maps", "[orbit]") {
  const auto hard = [&](std::string text) {
    const auto at = text.find("restitution");
    return text.insert(at, "young = 2e9\npoisson = 0.3\n") + "[penalty]\ntolerance = 1e-12\n";
  };
  int compared = 0;
  for (int i = 0; i < 12; ++i) {
    Draw r(20261127, i);
    auto m = i % 2 == 0 ? disc_in_shaking_box(r) : two_masses(r);
    m.text = hard(m.text);
    const auto scene = parse_scene(
        m.text, "random",
        i % 2 == 0 ? std::vector<std::string>{}
                   : std::vector<std::string>{"penalty.contact=kelvin-voigt", "penalty.kelvin_stiffness=1e6",
                                              "penalty.kelvin_damping=50"});
    const auto found = orbit(scene, {.formulation = "penalty", .settle = 20.3});
    CAPTURE(i, m.text, found.failure);
    if (!found.failure.empty() || found.impacts.empty()) continue;
    const auto D = differenced(scene, "penalty", m, found);
    REQUIRE(static_cast<Eigen::Index>(found.multipliers.size()) == D.rows());
    // Errors of the integration, 1e-12 a step, over displacements of 1e-5; forces δ^(3/2) limit both.
    CHECK(apart(found.multipliers, D) < 1e-4);
    ++compared;
  }
  WARN(fmt::format("{} penalty motions compared", compared));
  CHECK(compared >= 4);
}

// Multiple shooting: unstable motions of several periods from starts at which the map of all
// periods is far from linear.

TEST_CASE("unstable motions of three periods of a ball on a table", "[orbit]") {
  // The table moves by A sin(Ωt + φ). Between impacts i and i + 1, a time τ apart, the ball falls
  // from the table with the speed w_i + e u_i, u_i the approach speed and w_i that of the table:
  //     A sin(Ωt_i + φ) + (w_i + e u_i) τ − g τ²/2 = A sin(Ωt_{i+1} + φ),
  //     u_{i+1} = w_{i+1} − w_i − e u_i + g τ.
  // With A = 1.6 mm the motion is chaotic, and the map of three periods alone leads to no motion
  // from these starts.
  auto scene =
      read_scene(test::source_folder() / "cases/ball-on-table/scene.toml", {"curves.shake.amplitude=1.6e-3"});
  scene.nonsmooth.scheme = Scheme::event_driven;
  constexpr double A = 1.6e-3, frequency = 15.76357202168447, phase = 4.091478, g = 9.81, e = 0.8;
  constexpr double rate = 2 * std::numbers::pi * frequency;
  const auto height = [&](double t) { return A * std::sin(rate * t + phase); };
  const auto speed = [&](double t) { return A * rate * std::cos(rate * t + phase); };
  for (const double settle : {41.0, 43.0}) {
    const auto found = orbit(scene, {.periods = 3, .settle = settle});
    INFO(settle << ": " << found.failure);
    REQUIRE(found.failure.empty());
    CHECK_FALSE(found.stable);
    REQUIRE(found.impacts.size() >= 2);
    // Motions of one period have equal impacts.
    const auto [least, most] = std::ranges::minmax(found.impacts, {}, &OrbitImpact::speed);
    CHECK(most.speed - least.speed > 1e-3);
    for (std::size_t i = 0; i < found.impacts.size(); ++i) {
      const bool last = i + 1 == found.impacts.size();
      const auto &a = found.impacts[i], &b = last ? found.impacts.front() : found.impacts[i + 1];
      const double tau = b.t - a.t + (last ? 3 / frequency : 0), up = speed(a.t) + e * a.speed;
      // Residuals of 1e-8 of the state, relative to 0.01 m and 1 m/s, and the growth over a flight.
      CHECK(height(a.t) + up * tau - 0.5 * g * tau * tau == Approx(height(b.t)).margin(1e-8));
      CHECK(speed(b.t) - up + g * tau == Approx(b.speed).epsilon(1e-6));
    }
  }
}
