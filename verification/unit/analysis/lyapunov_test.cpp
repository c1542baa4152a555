// Lyapunov exponents: refusals, perturbations that vanish in finite time, and the sum rule over random
// scenes with impacts.
#include "analysis/lyapunov.hpp"

#include "verification/random_scenes/numbers.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;
using Catch::Matchers::Contains;
using verification::random_scenes::Draw;
using verification::random_scenes::toml;

namespace {

const std::string by_events = "[nonsmooth]\nscheme = \"event-driven\"\ntolerance = 1e-12\n";

std::string refused_exponents(const std::string& text, const LyapunovRequest& request,
                              const std::vector<std::string>& options = {}) {
  return test::refusal_of<std::exception>([&] { lyapunov(parse_scene(text, "s.toml", options), request); });
}

std::string surface(double restitution, const std::string& more = "") {
  return fmt::format("[surfaces.s]\nrestitution = {:.17g}\n", restitution) + more;
}

/// A ball above a fixed floor.
std::string dropped(double restitution, double duration) {
  return "gravity = [0, -9.81]\n" + test::body("ball", 0.3, 3e-4, "position = [0, 0.1]\n") +
         test::guide("rail", "ground", "ball", {0, 1}) +
         "[contacts.floor]\ntype = \"plane\"\nbetween = [\"ground\", \"ball\"]\nradius = 0.05\n"
         "surface = \"s\"\n" +
         surface(restitution) + test::run_for(duration) + by_events;
}

std::string shaking(double amplitude, double period) {
  return fmt::format("[curves.shake]\nshape = \"harmonic\"\namplitude = {:.17g}\nperiod = {:.17g}\n",
                     amplitude, period);
}

/// A disc between two walls of a box that shakes.
std::string disc_in_box(Draw& r) {
  const double half = r.between(0.07, 0.09);
  return test::body("box", 1, 0.01) + test::body("disc", r.between(0.1, 1), 1e-3, "velocity = [0.3, 0]\n") +
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
[drives.shaker]
joint = 'guide'
position = 'shake'
)",
              -half, half) +
         surface(r.between(0.5, 0.95)) + shaking(r.between(0.01, 0.02), r.between(0.08, 0.2)) +
         test::run_for(10) + by_events;
}

/// Two masses with springs and dampers, one driven by a force, the other with a stop.
std::string masses_with_stop(Draw& r) {
  const auto damper = [&] { return fmt::format("damping = {:.17g}\n", r.between(0.2, 2)); };
  return test::body("one", r.between(0.3, 1), 0.01) +
         test::body("two", r.between(0.3, 1), 0.01, "position = [1, 0]\n") +
         test::guide("first", "ground", "one") + test::guide("second", "ground", "two") +
         test::spring("base", "ground", "one", {-1, 0}, {0, 0}, r.between(100, 400), 1, damper()) +
         test::spring("link", "one", "two", {0, 0}, {0, 0}, r.between(100, 400), 1, damper()) +
         toml(R"([contacts.stop]
type = 'travel-stop'
joint = 'second'
upper = {}
surface = 's'
[drives.shaker]
joint = 'first'
force = 'shake'
against = 'time'
)",
              1 + r.between(0.002, 0.01)) +
         surface(r.between(0.5, 0.9)) + shaking(r.between(2, 6), r.between(0.2, 0.4)) + test::run_for(12) +
         by_events;
}

/// A double pendulum on the pin of a turning crank, with a stop: curved constraints and a driven
/// coordinate.
std::string pendulum_with_stop(Draw& r) {
  const double arm = r.between(0.05, 0.08), length = r.between(0.1, 0.2);
  const auto damping = [&] { return r.between(0, 0.005); };
  return "gravity = [0, -9.81]\n" + test::body("crank", 1, 0.01) +
         test::body("bar", r.between(0.5, 2), r.between(0.002, 0.01),
                    fmt::format("position = [{:.17g}, {:.17g}]\n", arm, -length)) +
         test::body("tip", r.between(0.2, 1), r.between(0.001, 0.005),
                    fmt::format("position = [{:.17g}, {:.17g}]\n", arm, -3 * length)) +
         test::pin("main", "ground", "crank") + test::pin("pivot", "crank", "bar", {arm, 0}, {0, length}) +
         test::pin("knee", "bar", "tip", {0, -length}, {0, length}) +
         toml(R"([loads.first]
type = 'torsional-spring-damper'
between = ['ground', 'bar']
stiffness = {}
damping = {}
[loads.second]
type = 'torsional-spring-damper'
between = ['bar', 'tip']
stiffness = {}
damping = {}
[contacts.stop]
type = 'plane'
between = ['ground', 'tip']
at = [[{}, 0], [0, 0]]
axis = [0, -1]
radius = 0
surface = 's'
[drives.motor]
joint = 'main'
speed = {}
)",
              r.between(0, 0.5), damping(), r.between(0, 0.5), damping(), -r.between(0.02, 0.06),
              r.between(4, 8)) +
         surface(r.between(0.6, 0.9)) + test::run_for(6) + by_events;
}

/// Two balls that collide under gravity on a shaken table: impacts of two free bodies.
std::string column_of_balls(Draw& r) {
  return "gravity = [0, -9.81]\n" + test::body("table", 1, 0.01) +
         test::body("lower", r.between(0.1, 0.5), 3e-4, "position = [0, 0.08]\n") +
         test::body("upper", r.between(0.1, 0.5), 3e-4, "position = [0, 0.25]\n") +
         test::guide("guide", "ground", "table", {0, 1}) + test::guide("rail", "ground", "lower", {0, 1}) +
         test::guide("mast", "ground", "upper", {0, 1}) + test::plane("table", "table", "lower", 0.05) +
         test::discs("pair", "lower", "upper", 0.05, 0.04) +
         "[drives.shaker]\njoint = \"guide\"\nposition = \"shake\"\n" + surface(r.between(0.85, 0.97)) +
         shaking(r.between(0.008, 0.015), r.between(0.06, 0.1)) + test::run_for(5) + by_events;
}

/// A spinning disc in a box with friction and tangential restitution: impacts that couple the normal
/// and the tangent.
std::string spinning_disc(Draw& r) {
  const auto side = [](const char* name, const char* at, const char* axis) {
    return test::plane(fmt::format("{}", name), "box", "disc", 0.05, "s",
                       fmt::format("at = [[{}], [0, 0]]\naxis = [{}]\n", at, axis));
  };
  return test::body("box", 5, 0.1) +
         test::body("disc", r.between(0.2, 1), r.between(2e-4, 1e-3),
                    fmt::format("velocity = [{:.17g}, {:.17g}]\nangular_velocity = {:.17g}\n",
                                r.between(0.5, 1), r.between(0.5, 1), r.either_way(20))) +
         test::guide("guide", "ground", "box", {0.6, 0.8}) + side("left", "-0.11, 0", "0, -1") +
         side("right", "0.12, 0", "0, 1") + side("low", "0, -0.13", "1, 0") +
         side("high", "0, 0.1", "-1, 0") +
         surface(r.between(0.8, 0.95), fmt::format("friction = {:.17g}\ntangential_restitution = {:.17g}\n",
                                                   r.between(0.1, 0.5), r.between(0.3, 0.8))) +
         "[drives.shaker]\njoint = \"guide\"\nposition = \"shake\"\n" +
         shaking(r.between(0.005, 0.01), r.between(0.08, 0.15)) + test::run_for(8) + by_events;
}

struct SceneKind {
  const char* name;
  std::string (*scene)(Draw&);
};
constexpr SceneKind scene_kinds[] = {{"disc in a shaking box", disc_in_box},
                                     {"two masses with a stop", masses_with_stop},
                                     {"pendulums with a stop", pendulum_with_stop},
                                     {"column of two balls", column_of_balls},
                                     {"spinning disc with friction", spinning_disc}};

}  // namespace

TEST_CASE("requests without Lyapunov exponents are refused", "[lyapunov]") {
  const auto ball = dropped(0.9, 1);
  CHECK_THAT(refused_exponents(ball, {.exponents = -1}), Contains("exponents: must be 0 or greater"));
  CHECK_THAT(refused_exponents(ball, {}, {"nonsmooth.scheme=moreau-jean", "nonsmooth.step=1e-4"}),
             Contains("exponents of time stepping are not available"));
  CHECK_THAT(refused_exponents(ball, {.batches = 3}), Contains("batches: must be 4 or greater"));
  CHECK_THAT(refused_exponents(ball, {.transient = 2}),
             Contains("transient: must be at least 0 and less than"));
  const auto crank = test::body("crank", 1, 0.01) + test::pin("main", "ground", "crank") +
                     "[drives.motor]\njoint = \"main\"\nspeed = 10\n" + test::run_for(1) + by_events;
  CHECK_THAT(refused_exponents(crank, {}), Contains("no degrees of freedom"));
}

TEST_CASE("a grazing impact ends the run with its reason", "[lyapunov]") {
  // A point passes a disc of 0.2 m at a distance of 0.2 m - 2 nm: it meets it at 1.4e-4 of its speed.
  const auto text =
      "[bodies.ball]\nmass = 1\npoint = true\nposition = [0, 2e-9]\nvelocity = [1, 0]\n"
      "[contacts.disc]\ntype = \"discs\"\nbetween = [\"ground\", \"ball\"]\nat = [[1, 0.2], [0, 0]]\n"
      "radii = [0.1, 0.1]\nsurface = \"s\"\n" +
      surface(1) + test::run_for(2) + by_events;
  const auto found = lyapunov(parse_scene(text, "s.toml"), {.transient = 0.1});
  CHECK(found.failure.empty());
  CHECK_THAT(found.stopped, Contains("contact disc grazes"));
  CHECK(found.batches == 9);  // of 0.095 s up to 1 s
  CHECK(found.exponents.size() == 4);
  const auto fewer = lyapunov(parse_scene(text, "s.toml"), {.batches = 4, .transient = 0.1});
  CHECK_THAT(fewer.failure, Contains("only 1 of 4 batches are complete"));
}

TEST_CASE("perturbations that a lasting contact ends have the exponent minus infinity", "[lyapunov]") {
  const auto found = lyapunov(parse_scene(dropped(0.5, 2), "s.toml"), {.transient = 0.1});
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
                    "[contacts.floor]\ntype = \"plane\"\nbetween = [\"ground\", \"disc\"]\nradius = "
                    "0.05\nsurface = \"s\"\n" +
                    surface(0.5) + test::run_for(2 + half_turns) + by_events;
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
  WARN(fmt::format("{} scenes with {} impacts, greatest relative error {:.2g}",
                   compared[0] + compared[1] + compared[2] + compared[3] + compared[4], impacts, worst));
  for (const int count : compared) CHECK(count >= 4);
}
