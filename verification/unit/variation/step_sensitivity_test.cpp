// Derivatives of time stepping: first order in the step, against closed forms and event-driven
// derivatives. (The claims of "sensitivities" contain the orders of a ball and a pendulum.)
//
// The instant of an impact lies anywhere within its step, so that the error of one run is a
// sawtooth of the step. The order is that of the root mean square over steps of slightly different
// length.
#include "analysis/sensitivity.hpp"
#include "verification/references/sensitivity.hpp"
#include "verification/support/rig.hpp"
#include "verification/unit/variation/varied_scenes.hpp"

using namespace freeplay;
using namespace freeplay::test::varied;
using Catch::Matchers::Contains;

namespace {

constexpr int levels = 4;

struct Convergence {
  std::vector<double> errors;  ///< relative, of each level
  int compared = 0;
};

Sensitivities by_steps(const RandomCase& c, double step, bool errors = false) {
  return sensitivities(test::scene_by(test::fixed_steps(step), c.text),
                       {.of = c.quantities, .to = c.keys, .errors = errors});
}

/// Relative errors of all derivatives for steps from `coarsest` on, against those of event-driven runs.
/// Derivatives that one of the runs refuses do not take part, nor those that vanish.
Convergence converge(const RandomCase& c, double coarsest, int phases) {
  const auto events = sensitivities(test::scene_by(test::event_driven, c.text),
                                    {.of = c.quantities, .to = c.keys, .errors = false});
  std::vector<std::vector<Sensitivities>> runs(levels);
  for (int level = 0; level < levels; ++level)
    for (int i = 0; i < phases; ++i)
      runs[static_cast<std::size_t>(level)].push_back(
          by_steps(c, coarsest * std::pow(0.5, level) * (1 + 0.4 * (i + 0.5) / phases)));
  Convergence found;
  found.errors.assign(levels, 0);
  for (std::size_t q = 0; q < c.quantities.size(); ++q)
    for (std::size_t k = 0; k < c.keys.size(); ++k) {
      const double exact = events.quantities[q].derivatives[k];
      const auto& first = runs.back().front();
      if (!(std::abs(exact) > 1e-6 * std::abs(first.quantities[q].value / first.key_values[k]))) continue;
      std::vector<double> squares;
      bool known = true;
      for (const auto& level : runs) {
        double sum = 0;
        for (const auto& run : level) {
          const double error = run.quantities[q].derivatives[k] / exact - 1;
          known = known && std::isfinite(error);
          sum += error * error;
        }
        squares.push_back(sum / phases);
      }
      found.compared += known;
      for (std::size_t i = 0; known && i < squares.size(); ++i) found.errors[i] += squares[i];
    }
  for (double& e : found.errors) e = std::sqrt(e / std::max(1, found.compared));
  return found;
}

RandomCase dropped_ball(double duration, std::vector<std::string> of, std::vector<std::string> to) {
  return {"gravity = [0, -9.81]\n" + test::body("ball", 0.3, 3e-4, "position = [0, 0.55]\n") +
              test::plane("table", "ground", "ball", 0.05, "hard") + test::surface("hard", 0.5) +
              test::run_for(duration, "start = \"given\"\n"),
          std::move(of), std::move(to)};
}

}  // namespace

TEST_CASE("derivatives of a stepped ball are exact before its impact, and those of its steps after it",
          "[sensitivity]") {
  const reference::BallDerivatives b{0.5L, 9.81L, 0.5L};
  // Until the first impact the flight is a parabola, which the midpoint rule integrates exactly.
  const auto first = by_steps(dropped_ball(0.5, {"event.1.t"}, {"initial.ball.y"}), 1e-3);
  check_derivatives(first.quantities[0], {static_cast<double>(b.time_by_height(1))}, 1e-11);
  // The derivative of the discrete map is 1 or −e here.
  const auto once = by_steps(dropped_ball(0.5, {"end.ball.y"}, {"initial.ball.y"}), 1e-4);
  check_derivatives(once.quantities[0], {static_cast<double>(b.end_by_height(0.5L))}, 3e-3);
}

TEST_CASE("derivatives of a stepped block that slides up a slope and sticks are exact", "[sensitivity]") {
  // Parabolas, so that the instant of the end of sliding is exact.
  const auto found = converge(
      {"gravity = [-3, -9]\n" + test::body("block", 2, 0.01, "position = [0, 0.05]\nvelocity = [1.5, 0]\n") +
           test::plane("rear", "ground", "block", 0, "wood", "at = [[0, 0], [-0.1, -0.05]]\n") +
           test::plane("front", "ground", "block", 0, "wood", "at = [[0, 0], [0.1, -0.05]]\n") +
           test::surface("wood", 0.3, 0.5) + test::run_for(0.5, "start = \"given\"\n"),
       {"end.block.x"},
       {"initial.block.vx", "surfaces.wood.friction", "gravity[0]"}},
      1e-2, 10);
  CHECK(found.compared >= 3);
  CHECK(found.errors[0] < 1e-10);
}

TEST_CASE("the work of a belt on a sliding disc is differentiated through its end of sliding",
          "[sensitivity]") {
  // A disc at rest slides on a belt of speed V until it rolls: W = V²/(1/m + r²/I), for any
  // friction. The power of the belt jumps at the end of sliding.
  const double m = 2, inertia = 0.01, r = 0.05, V = 3, mobility = 1 / m + r * r / inertia;
  const auto s = sensitivities(
      parse_scene(
          "gravity = [0, -9.81]\n" + test::body("belt", 5, 1, "velocity = [3, 0]\n") +
              test::body("disc", m, inertia, "position = [0, 0.05]\n") +
              test::guide("guide", "ground", "belt") + test::plane("belt", "belt", "disc", 0.05) +
              test::surface("s", 0, 0.3) +
              "[drives.m]\njoint = \"guide\"\nvelocity = \"v\"\n[curves.v]\nvalue = 3\n" +
              test::run_for(1, "start = \"given\"\n[nonsmooth]\nscheme = \"moreau-jean\"\nstep = 2e-4\n"),
          "belt"),
      {.of = {"energy.work_of_drives"},
       .to = {"bodies.disc.mass", "bodies.disc.inertia", "surfaces.s.friction"},
       .errors = false});
  const auto& q = s.quantities[0];
  CHECK(q.value == Approx(V * V / mobility).epsilon(1e-3));
  // First order: the sliding lasts for some 1000 steps.
  CHECK(q.derivatives[0] == Approx(std::pow(V / (m * mobility), 2)).epsilon(5e-3));
  CHECK(q.derivatives[1] == Approx(std::pow(V * r / (inertia * mobility), 2)).epsilon(5e-3));
  CHECK(std::abs(q.derivatives[2]) < 5e-3 * q.value / 0.3);
}

TEST_CASE("errors of stepped derivatives bound the true ones", "[sensitivity]") {
  const reference::BallDerivatives b{0.5L, 9.81L, 0.5L};
  const auto c =
      dropped_ball(0.85, {"event.2.t", "event.3.t"}, {"surfaces.hard.restitution", "initial.ball.y"});
  int beyond = 0, all = 0;
  for (int i = 0; i < 20; ++i) {
    const auto s = by_steps(c, 1e-3 * (1 + 0.02 * i), true);
    for (std::size_t q = 0; q < 2; ++q)
      for (std::size_t k = 0; k < 2; ++k) {
        const int n = static_cast<int>(q) + 2;
        const double exact = static_cast<double>(k == 0 ? b.time_by_restitution(n) : b.time_by_height(n));
        if (!std::isfinite(s.quantities[q].derivatives[k])) continue;
        ++all;
        beyond += !(std::abs(s.quantities[q].derivatives[k] - exact) <= s.quantities[q].errors[k]);
      }
  }
  CAPTURE(beyond, all);
  CHECK(all > 60);
  CHECK(beyond <= 0.05 * all);
}

// The geometric mean of the errors of the scenes, since few runs of each are made.
TEST_CASE("derivatives of random stepped scenes are of first order", "[sensitivity]") {
  int compared = 0, scenes = 0;
  std::vector<double> means(levels, 1);
  for (int i = 0; i < 8; ++i) {
    Draw r(20261126, i);
    const auto c = random_case(i, r);
    const auto found = converge(c, parse_scene(c.text, "random").run.duration / 200, 3);
    CAPTURE(i, found.errors);
    compared += found.compared;
    if (found.compared == 0) continue;
    ++scenes;
    // A derivative with an error that does not vanish would keep the error of its scene. Steps
    // shrink to an eighth; three runs of each leave a factor of two.
    CHECK(found.errors.back() < 0.5 * found.errors.front());
    for (std::size_t k = 0; k < means.size(); ++k) means[k] *= found.errors[k];
  }
  for (double& mean : means) mean = std::pow(mean, 1.0 / scenes);
  std::vector<double> steps;
  for (int i = 0; i < levels; ++i) steps.push_back(std::pow(0.5, i));
  const double order = test::observed_order(steps, means);
  WARN(fmt::format("order {:.2f}, errors {:.2g} to {:.2g}, {} derivatives of {} scenes", order, means.front(),
                   means.back(), compared, scenes));
  CHECK(order > 0.8);
  CHECK(order < 1.3);
  CHECK(scenes >= 5);
  CHECK(compared > 200);
}

TEST_CASE("impacts that steps do not resolve are refused with the reason", "[sensitivity]") {
  // Two impacts that act on each other within one step: a disc between two walls, nearly at once.
  const std::string cradle = test::body("one", 1, 0.004, "position = [-0.2501, 0]\nvelocity = [1, 0]\n") +
                             test::body("two", 1, 0.004, "position = [0, 0]\n") +
                             test::body("three", 1, 0.004, "position = [0.2501, 0]\nvelocity = [-1, 0]\n") +
                             test::discs("left", "one", "two", 0.1, 0.1) +
                             test::discs("right", "two", "three", 0.1, 0.1) + test::surface("s", 0.9) +
                             test::run_for(0.1, "start = \"given\"\n");
  const auto s = by_steps({cradle, {"end.three.vx"}, {"initial.one.vx"}}, 1e-3);
  CHECK(std::isnan(s.quantities[0].derivatives[0]));
  CHECK_THAT(s.quantities[0].reasons[0], Contains("act on each other"));
}

// Impacts are located to step_tolerance times the radius, relative to a bounce of 0.1 m: 1e-7 for
// 1e-7. Each of the bounces and flights amplifies this by about ten.
TEST_CASE("derivatives of adaptive time stepping follow the tolerance", "[sensitivity]") {
  const reference::BallDerivatives b{0.5L, 9.81L, 0.5L};
  const auto c =
      dropped_ball(0.85, {"event.2.t", "event.3.t"}, {"surfaces.hard.restitution", "initial.ball.y"});
  const auto s = sensitivities(test::scene_by(test::chosen_steps, c.text, {"nonsmooth.step_tolerance=1e-7"}),
                               {.of = c.quantities, .to = c.keys});
  for (const int n : {2, 3}) {
    const auto& found = s.quantities[static_cast<std::size_t>(n - 2)];
    check_derivatives(
        found, {static_cast<double>(b.time_by_restitution(n)), static_cast<double>(b.time_by_height(n))},
        1e-5);
  }
}
