// Lyapunov exponents: refusals, perturbations that vanish in finite time, and the sum rule over random
// scenes with impacts.
#include "analysis/lyapunov.hpp"

#include "verification/support/rig.hpp"
#include "verification/unit/analysis/orbit_maps.hpp"

using namespace freeplay;
using namespace verification::maps;
using Catch::Matchers::Contains;

namespace {

/// A ball above a fixed floor.
Scene dropped(double restitution, double duration, const std::vector<std::string>& options = {}) {
  return parse_scene("gravity = [0, -9.81]\n" + test::body("ball", 0.3, 3e-4, "position = [0, 0.1]\n") +
                         test::guide("rail", "ground", "ball", {0, 1}) +
                         test::plane("floor", "ground", "ball", 0.05) + test::surface("s", restitution) +
                         test::run_for(duration) + event_driven,
                     "s.toml", options);
}

std::string short_box(Draw& r) { return disc_in_box(r, {0.5, 0.95}) + test::run_for(4); }

std::string short_masses(Draw& r) { return masses_with_stop(r, {0.5, 0.9}, {0.2, 2}) + test::run_for(5); }

/// A double pendulum on the pin of a turning crank, with a stop: curved constraints and a driven
/// coordinate.
std::string pendulum_with_stop(Draw& r) {
  const double arm = r.between(0.05, 0.08), length = r.between(0.1, 0.2), bar = r.between(0.5, 2),
               tip = r.between(0.2, 1), stop = -r.between(0.02, 0.06), speed = r.between(4, 8);
  const auto at = [&](double y) { return fmt::format("position = [{}, {}]\n", arm, -y); };
  const auto torsion = [&](const char* name, const char* i, const char* j) {
    const double stiffness = r.between(0, 0.5);
    return test::torsion(name, i, j, stiffness, fmt::format("damping = {}\n", r.between(0, 0.005)));
  };
  const auto first = torsion("first", "ground", "bar"), second = torsion("second", "bar", "tip");
  const double bar_inertia = r.between(0.002, 0.01), tip_inertia = r.between(0.001, 0.005);
  return "gravity = [0, -9.81]\n" + test::body("crank", 1, 0.01) +
         test::body("bar", bar, bar_inertia, at(length)) +
         test::body("tip", tip, tip_inertia, at(3 * length)) + test::pin("main", "ground", "crank") +
         test::pin("pivot", "crank", "bar", {arm, 0}, {0, length}) +
         test::pin("knee", "bar", "tip", {0, -length}, {0, length}) + first + second +
         wall("stop", "ground", "tip", 0, {stop, 0}, {0, -1}) + test::motor("motor", "main", speed) +
         test::surface("s", r.between(0.6, 0.9)) + test::run_for(3) + event_driven;
}

/// Two balls that collide under gravity on a shaken table: impacts of two free bodies.
std::string column_of_balls(Draw& r) {
  const double lower = r.between(0.1, 0.5), upper = r.between(0.1, 0.5), amplitude = r.between(0.008, 0.015),
               period = r.between(0.06, 0.1);
  return "gravity = [0, -9.81]\n" + test::body("table", 1, 0.01) +
         test::body("lower", lower, 3e-4, "position = [0, 0.08]\n") +
         test::body("upper", upper, 3e-4, "position = [0, 0.25]\n") +
         test::guide("guide", "ground", "table", {0, 1}) + test::guide("rail", "ground", "lower", {0, 1}) +
         test::guide("mast", "ground", "upper", {0, 1}) + test::plane("table", "table", "lower", 0.05) +
         test::discs("pair", "lower", "upper", 0.05, 0.04) + test::surface("s", r.between(0.85, 0.97)) +
         shaker("guide", amplitude, period) + test::run_for(2.5) + event_driven;
}

/// A spinning disc in a box with friction and tangential restitution: impacts that couple the normal
/// and the tangent.
std::string spinning_disc(Draw& r) {
  const double mass = r.between(0.2, 1), inertia = r.between(2e-4, 1e-3), vx = r.between(0.5, 1),
               vy = r.between(0.5, 1), spin = r.either_way(20), e = r.between(0.8, 0.95),
               friction = r.between(0.1, 0.5), tangential = r.between(0.3, 0.8),
               amplitude = r.between(0.005, 0.01), period = r.between(0.08, 0.15);
  return test::body("box", 5, 0.1) +
         test::body("disc", mass, inertia,
                    fmt::format("velocity = [{}, {}]\nangular_velocity = {}\n", vx, vy, spin)) +
         test::guide("guide", "ground", "box", {0.6, 0.8}) +
         wall("left", "box", "disc", 0.05, {-0.11, 0}, {0, -1}) +
         wall("right", "box", "disc", 0.05, {0.12, 0}, {0, 1}) +
         wall("low", "box", "disc", 0.05, {0, -0.13}, {1, 0}) +
         wall("high", "box", "disc", 0.05, {0, 0.1}, {-1, 0}) +
         test::surface("s", e, friction, fmt::format("tangential_restitution = {}\n", tangential)) +
         shaker("guide", amplitude, period) + test::run_for(3.5) + event_driven;
}

struct SceneKind {
  const char* name;
  std::string (*scene)(Draw&);
};
constexpr SceneKind scene_kinds[] = {{"disc in a shaking box", short_box},
                                     {"two masses with a stop", short_masses},
                                     {"pendulums with a stop", pendulum_with_stop},
                                     {"column of two balls", column_of_balls},
                                     {"spinning disc with friction", spinning_disc}};

}  // namespace

TEST_CASE("requests without Lyapunov exponents are refused", "[lyapunov]") {
  const auto refused = [](const Scene& scene, const LyapunovRequest& request, const char* reason) {
    CHECK_THROWS_WITH(lyapunov(scene, request), Contains(reason));
  };
  const auto ball = dropped(0.9, 1);
  refused(ball, {.exponents = -1}, "exponents: must be 0 or greater");
  refused(dropped(0.9, 1, {"nonsmooth.scheme=moreau-jean", "nonsmooth.step=1e-4"}), {},
          "exponents of time stepping are not available");
  refused(ball, {.batches = 3}, "batches: must be 4 or greater");
  refused(ball, {.transient = 2}, "transient: must be at least 0 and less than");
  const auto crank = test::body("crank", 1, 0.01) + test::pin("main", "ground", "crank") +
                     test::motor("motor", "main", 10) + test::run_for(1) + event_driven;
  refused(parse_scene(crank, "s.toml"), {}, "no degrees of freedom");
}

TEST_CASE("a grazing impact ends the run with its reason", "[lyapunov]") {
  // A point passes a disc of 0.2 m at a distance of 0.2 m - 2 nm: it meets it at 1.4e-4 of its speed.
  const auto text = "[bodies.ball]\nmass = 1\npoint = true\nposition = [0, 2e-9]\nvelocity = [1, 0]\n" +
                    test::discs("disc", "ground", "ball", 0.1, 0.1, "s", "at = [[1, 0.2], [0, 0]]\n") +
                    test::surface("s", 1) + test::run_for(2) + event_driven;
  const auto found = lyapunov(parse_scene(text, "s.toml"), {.transient = 0.1});
  CHECK(found.failure.empty());
  CHECK_THAT(found.stopped, Contains("contact disc grazes"));
  CHECK(found.batches == 9);  // of 0.095 s up to 1 s
  CHECK(found.exponents.size() == 4);
  const auto fewer = lyapunov(parse_scene(text, "s.toml"), {.batches = 4, .transient = 0.1});
  CHECK_THAT(fewer.failure, Contains("only 1 of 4 batches are complete"));
}

TEST_CASE("perturbations that a lasting contact ends have the exponent minus infinity", "[lyapunov]") {
  const auto found = lyapunov(dropped(0.5, 2), {.transient = 0.1});
  REQUIRE(found.failure.empty());
  REQUIRE(found.exponents.size() == 2);
  for (const auto& e : found.exponents) {
    CHECK(e.value == -INFINITY);
    CHECK(std::isnan(e.error));
    CHECK_THAT(e.reason, Contains("vanishes in finite time, t = "));
  }
  CHECK(found.sum == -INFINITY);
  CHECK(std::isnan(found.predicted));
  CHECK_THAT(found.unpredicted, Contains("a contact lasts"));
}

TEST_CASE("a contact that is closed at the start leaves the other exponents", "[lyapunov]") {
  // A disc rests on a plane. Beside it is a damped oscillator, m ẍ + c ẋ + k x = 0, whose exponents both are
  // −c/(2m). Within half a turn its perturbations return to their directions.
  const double half_turns = 20 * std::acos(-1.0) / std::sqrt(25 - 0.09);
  const auto text = "gravity = [0, -9.81]\n" + test::body("disc", 1, 0.01, "position = [0, 0.05]\n") +
                    test::body("mass", 2, 0.01, "position = [1.1, 0]\n") +
                    test::guide("rail", "ground", "mass") + test::guide("mast", "ground", "disc", {0, 1}) +
                    test::spring("spring", "ground", "mass", {-1, 0}, {0, 0}, 50, 2, "damping = 1.2\n") +
                    test::plane("floor", "ground", "disc", 0.05) + test::surface("s", 0.5) +
                    test::run_for(2 + half_turns) + event_driven;
  const auto found = lyapunov(parse_scene(text, "s.toml"), {.transient = 2});
  REQUIRE(found.failure.empty());
  REQUIRE(found.exponents.size() == 4);
  for (const std::size_t i : {0U, 1U}) CHECK(std::abs(found.exponents[i].value + 0.3) < 1e-9);
  for (const std::size_t i : {2U, 3U}) CHECK(found.exponents[i].value == -INFINITY);
}

TEST_CASE("the sum of the exponents of random scenes follows from divergence and impacts", "[lyapunov]") {
  int compared[std::size(scene_kinds)] = {};
  long impacts = 0;
  double worst = 0;
  for (int i = 0; i < 40; ++i) {
    const auto which = static_cast<std::size_t>(i) % std::size(scene_kinds);
    Draw r(20261127, i);
    const auto text = scene_kinds[which].scene(r);
    CAPTURE(i, scene_kinds[which].name, text);
    const auto found = lyapunov(parse_scene(text, "random"), {});
    CAPTURE(found.failure, found.unpredicted);
    if (!found.failure.empty() || !found.unpredicted.empty() || found.impacts == 0) continue;
    double scale = 0;
    for (const auto& e : found.exponents) scale += std::abs(e.value);
    const double error = std::abs(found.sum - found.predicted) / scale;
    worst = std::max(worst, error);
    impacts += found.impacts;
    ++compared[which];
    CAPTURE(found.sum, found.predicted, found.impacts);
    // Errors of the integration, 1e-12 a step, and of the differences at events, 1e-12 each, with
    // derivatives that grow by factors of 1e2 between orthonormalisations.
    CHECK(error < 1e-8);
  }
  WARN(fmt::format("{} impacts, greatest relative error {:.2g}", impacts, worst));
  for (const int count : compared) CHECK(count >= 4);
}
