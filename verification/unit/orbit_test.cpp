// Periodic motions: refusals, a pendulum of unknown period, and multipliers of random scenes against
// central differences of the return map.
#include <fmt/format.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <complex>
#include <functional>
#include <string>
#include <vector>

#include "facade/orbit.hpp"
#include "facade/simulation.hpp"
#include "mechanism/scene.hpp"
#include "numerics/dense.hpp"
#include "verification/random_scenes/numbers.hpp"
#include "verification/references/sensitivity.hpp"
#include "verification/support/scene_text.hpp"
#include "verification/support/texts.hpp"

using namespace freeplay;
using Catch::Matchers::Contains;
using verification::random_scenes::Draw;
using verification::random_scenes::toml;

namespace {

const std::string event_driven = "[nonsmooth]\nscheme = \"event-driven\"\ntolerance = 1e-12\n";

std::string ball_on_table(const std::string& more = "") {
  return "gravity = [0, -9.81]\n" + test::body("table", 1, 0.01) +
         test::body("ball", 0.3, 3e-4, "position = [0, 0.08]\n") +
         test::guide("guide", "ground", "table", {0, 1}) + test::guide("rail", "ground", "ball", {0, 1}) +
         R"([contacts.pair]
type = "plane"
between = ["table", "ball"]
radius = 0.05
surface = "hard"
[surfaces.hard]
restitution = 0.5
[curves.shake]
shape = "harmonic"
amplitude = 3.2e-3
frequency = 10
[drives.shaker]
joint = "guide"
position = "shake"
)" + test::run_for(1) +
         event_driven + more;
}

std::string refusal(const std::string& text, const OrbitRequest& request,
                    const std::vector<std::string>& options = {}) {
  return test::refusal_of<std::exception>([&] { orbit(parse_scene(text, "s.toml", options), request); });
}

const std::string pendulum = "gravity = [0, -9.81]\n" +
                             test::body("bar", 1, 0.01, "position = [0.2, 0]\nangle = 1.5707963267948966\n") +
                             test::pin("pivot", "ground", "bar", {0, 0}, {0, 0.2}) + test::run_for(1) +
                             event_driven;

/// A scene with its own coordinates u, on which the return map is differenced.
struct RandomMap {
  std::string text;
  std::function<std::vector<double>(const State&)> own;
  std::function<State(const State&, const std::vector<double>&)> with;
};

/// Coordinates of bodies on rails along x: (x, vx) of each.
RandomMap on_rails(std::string text, std::vector<std::size_t> bodies) {
  return {std::move(text),
          [=](const State& s) {
            std::vector<double> u;
            for (const auto b : bodies) u.insert(u.end(), {s.q[3 * b], s.v[3 * b]});
            return u;
          },
          [=](const State& s, const std::vector<double>& u) {
            State moved = s;
            for (std::size_t i = 0; i < bodies.size(); ++i) {
              moved.q[3 * bodies[i]] = u[2 * i];
              moved.v[3 * bodies[i]] = u[2 * i + 1];
            }
            return moved;
          }};
}

std::string harmonic(double amplitude, double period) {
  return fmt::format("[curves.shake]\nshape = \"harmonic\"\namplitude = {:.17g}\nperiod = {:.17g}\n",
                     amplitude, period);
}

/// A disc between two walls of a box that shakes.
RandomMap disc_in_shaking_box(Draw& r) {
  const double half = r.between(0.07, 0.09);
  return on_rails(test::body("box", 1, 0.01) +
                      test::body("disc", r.between(0.1, 1), 1e-3, "velocity = [0.3, 0]\n") +
                      test::guide("guide", "ground", "box") + test::guide("rail", "ground", "disc") +
                      toml(R"([contacts.left]
type = 'plane'
between = ['box', 'disc']
at = [[{}, 0], [0, 0]]
axis = [0, -1]
radius = 0.05
surface = 's'
[contacts.right]
type = 'plane'
between = ['box', 'disc']
at = [[{}, 0], [0, 0]]
axis = [0, 1]
radius = 0.05
surface = 's'
[surfaces.s]
restitution = {}
[drives.shaker]
joint = 'guide'
position = 'shake'
)",
                           -half, half, r.between(0.3, 0.7)) +
                      harmonic(r.between(0.01, 0.02), r.between(0.08, 0.2)) + test::run_for(1) + event_driven,
                  {1});
}

/// A pendulum on the pin of a crank of constant speed, with a spring, a damper and a stop.
RandomMap pendulum_on_crank(Draw& r) {
  const double arm = r.between(0.03, 0.06), length = r.between(0.15, 0.25);
  const auto pose = [=](const State& s, double angle, double rate) {
    State moved = s;
    const double crank = s.q[2], turn = s.v[2];
    moved.q[3] = arm * std::cos(crank) + length * std::sin(angle);
    moved.q[4] = arm * std::sin(crank) - length * std::cos(angle);
    moved.q[5] = angle;
    moved.v[3] = -arm * turn * std::sin(crank) + length * rate * std::cos(angle);
    moved.v[4] = arm * turn * std::cos(crank) + length * rate * std::sin(angle);
    moved.v[5] = rate;
    return moved;
  };
  return {"gravity = [0, -9.81]\n" + test::body("crank", 1, 0.01) +
              test::body("bar", r.between(0.5, 2), r.between(0.005, 0.02),
                         fmt::format("position = [{}, {}]\n", arm, -length)) +
              test::pin("main", "ground", "crank") +
              test::pin("pivot", "crank", "bar", {arm, 0}, {0, length}) +
              toml(R"([loads.spring]
type = 'torsional-spring-damper'
between = ['ground', 'bar']
stiffness = {}
damping = {}
[contacts.stop]
type = 'plane'
between = ['ground', 'bar']
at = [[{}, 0], [0, {}]]
axis = [0, -1]
radius = 0
surface = 's'
[surfaces.s]
restitution = {}
[drives.motor]
joint = 'main'
speed = {}
)",
                   r.between(0.5, 2), r.between(0.01, 0.05), -r.between(0.01, 0.05), -length,
                   r.between(0.4, 0.8), r.between(6, 12)) +
              test::run_for(1) + event_driven,
          [](const State& s) {
            return std::vector{s.q[5], s.v[5]};
          },
          [=](const State& s, const std::vector<double>& u) { return pose(s, u[0], u[1]); }};
}

/// Two masses with springs and dampers, one driven by a force, the other with a stop.
RandomMap two_masses(Draw& r) {
  const auto damper = [&] { return fmt::format("damping = {:.17g}\n", r.between(0.5, 3)); };
  return on_rails(
      test::body("one", r.between(0.3, 1), 0.01) +
          test::body("two", r.between(0.3, 1), 0.01, "position = [1, 0]\n") +
          test::guide("first", "ground", "one") + test::guide("second", "ground", "two") +
          test::spring("base", "ground", "one", {-1, 0}, {0, 0}, r.between(100, 400), 1, damper()) +
          test::spring("link", "one", "two", {0, 0}, {0, 0}, r.between(100, 400), 1, damper()) +
          toml(R"([contacts.stop]
type = 'travel-stop'
joint = 'second'
upper = {}
surface = 's'
[surfaces.s]
restitution = {}
[drives.shaker]
joint = 'first'
force = 'shake'
against = 'time'
)",
               1 + r.between(0.002, 0.01), r.between(0.4, 0.8)) +
          harmonic(r.between(2, 6), r.between(0.2, 0.4)) + test::run_for(1) + event_driven,
      {0, 1});
}

/// A journal that stays in contact with a bearing, which shakes; without friction, with a damper. The
/// contact is closed at the section.
RandomMap journal_in_shaken_bearing(Draw& r) {
  const double clearance = r.between(0.01, 0.03);
  const auto pose = [=](const State& s, double angle, double rate) {
    State moved = s;
    moved.q[3] = s.q[0] + clearance * std::sin(angle);
    moved.q[4] = s.q[1] - clearance * std::cos(angle);
    moved.v[3] = s.v[0] + clearance * rate * std::cos(angle);
    moved.v[4] = s.v[1] + clearance * rate * std::sin(angle);
    return moved;
  };
  return {"gravity = [0, -9.81]\n" + test::body("bearing", 1, 0.01) +
              toml(R"([bodies.journal]
mass = {}
point = true
position = [0, {}]
[joints.pin]
type = 'revolute'
between = ['bearing', 'journal']
at = [[0, 0], [0, 0]]
clearance = {}
bearing_radius = 0.05
surface = 's'
[loads.damper]
type = 'spring-damper'
between = ['bearing', 'journal']
at = [[0.5, 0], [0, 0]]
stiffness = {}
damping = {}
free_length = 0.5
[surfaces.s]
restitution = 0.5
[drives.shaker]
joint = 'guide'
position = 'shake'
)",
                   r.between(0.5, 2), -clearance, clearance, r.between(5, 20), r.between(1, 5)) +
              test::guide("guide", "ground", "bearing") +
              harmonic(r.between(2e-4, 1e-3), r.between(0.2, 0.5)) + test::run_for(1) + event_driven,
          [](const State& s) {
            const double x = s.q[3] - s.q[0], y = s.q[4] - s.q[1], u = s.v[3] - s.v[0], w = s.v[4] - s.v[1];
            return std::vector{std::atan2(x, -y), (x * w - y * u) / (x * x + y * y)};
          },
          [=](const State& s, const std::vector<double>& u) { return pose(s, u[0], u[1]); }};
}

std::vector<double> map_of(const Scene& scene, const char* formulation, const RandomMap& m,
                           const State& start, double until, const std::vector<double>& u) {
  Simulation s(scene, formulation, {.start = m.with(start, u)});
  s.run({.until = until, .keep_events = false});
  return m.own(s.state());
}

/// Derivative of the return map by extrapolated central differences.
Eigen::MatrixXd differenced(const Scene& scene, const char* formulation, const RandomMap& m,
                            const Orbit& found) {
  const auto centre = m.own(found.state);
  const auto n = static_cast<Eigen::Index>(centre.size());
  Eigen::MatrixXd D(n, n);
  const double until = found.state.t + found.periods * found.period;
  for (Eigen::Index j = 0; j < n; ++j) {
    const auto slope = [&](double h) {
      auto low = centre, high = centre;
      low[static_cast<std::size_t>(j)] -= h;
      high[static_cast<std::size_t>(j)] += h;
      const auto a = map_of(scene, formulation, m, found.state, until, low),
                 b = map_of(scene, formulation, m, found.state, until, high);
      Eigen::VectorXd d(n);
      for (Eigen::Index i = 0; i < n; ++i)
        d[i] = (b[static_cast<std::size_t>(i)] - a[static_cast<std::size_t>(i)]) / (2 * h);
      return d;
    };
    constexpr double h = 1e-5;
    D.col(j) = (4 * slope(h) - slope(2 * h)) / 3;
  }
  return D;
}

}  // namespace

TEST_CASE("requests without a periodic motion are refused", "[orbit]") {
  const auto ball = ball_on_table();
  CHECK_THAT(refusal(ball, {}, {"nonsmooth.scheme=moreau-jean", "nonsmooth.step=1e-4"}),
             Contains("orbits of time stepping are not available"));
  CHECK_THAT(refusal(ball, {.periods = 0}), Contains("periods: must be 1 or greater"));
  CHECK_THAT(refusal(ball, {.settle = -1}), Contains("settle: must be 0 or greater"));
  CHECK_THAT(refusal(ball, {.period = 0.2}), Contains("contradicts the drives, whose period is 0.1 s"));
  CHECK_THAT(refusal(pendulum, {}), Contains("nothing in the scene depends on time"));
  // Two periods that have no common multiple among them.
  const auto second =
      "[curves.push]\nshape = \"harmonic\"\namplitude = 1\nperiod = 0.07\n[drives.second]\njoint "
      "= \"rail\"\nforce = \"push\"\nagainst = \"time\"\n";
  CHECK_THAT(refusal(ball_on_table(second), {}), Contains("periods of 0.1 s and 0.07 s"));
  const auto crank = test::body("crank", 1, 0.01) + test::pin("main", "ground", "crank") +
                     "[drives.motor]\njoint = \"main\"\nspeed = 10\n" + test::run_for(1) + event_driven;
  CHECK_THAT(refusal(crank, {}), Contains("no degrees of freedom"));
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
    const auto m = i % 4 == 0   ? disc_in_shaking_box(r)
                   : i % 4 == 1 ? pendulum_on_crank(r)
                   : i % 4 == 2 ? two_masses(r)
                                : journal_in_shaken_bearing(r);
    const auto scene = parse_scene(m.text, "random");
    const auto found = orbit(scene, {.settle = 20});
    CAPTURE(i, m.text, found.failure);
    if (!found.failure.empty() || (found.impacts.empty() && i % 4 < 3)) continue;
    const auto D = differenced(scene, "nonsmooth", m, found);
    REQUIRE(static_cast<Eigen::Index>(found.multipliers.size()) == D.rows());
    // Sums of powers do not depend on the order of multipliers, and are smooth where two coincide.
    Eigen::MatrixXd power = D;
    for (Eigen::Index k = 1; k <= D.rows(); ++k, power = power * D) {
      std::complex<double> sum = 0;
      double scale = 1;
      for (const auto& x : found.multipliers) {
        sum += std::pow(x, static_cast<double>(k));
        scale += std::pow(std::abs(x), static_cast<double>(k));
      }
      const double error = std::abs(sum - power.trace()) / scale;
      worst = std::max(worst, error);
      CAPTURE(k, sum, power.trace());
      // Errors of the integration, 1e-12 a step, over displacements of 1e-5.
      CHECK(error < 1e-5);
    }
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
    Eigen::MatrixXd power = D;
    for (Eigen::Index k = 1; k <= D.rows(); ++k, power = power * D) {
      std::complex<double> sum = 0;
      double scale = 1;
      for (const auto& x : found.multipliers) {
        sum += std::pow(x, static_cast<double>(k));
        scale += std::pow(std::abs(x), static_cast<double>(k));
      }
      CAPTURE(k, sum, power.trace());
      // Errors of the integration, 1e-12 a step, over displacements of 1e-5; forces δ^(3/2) limit both.
      CHECK(std::abs(sum - power.trace()) / scale < 1e-4);
    }
    ++compared;
  }
  WARN(fmt::format("{} penalty motions compared", compared));
  CHECK(compared >= 4);
}
