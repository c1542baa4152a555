// Derivatives of event-driven runs: refusals, and random scenes against Richardson-extrapolated
// differences of whole runs.
#include "facade/sensitivity.hpp"

#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <string>
#include <vector>

#include "io/files/output_file.hpp"
#include "mechanism/scene.hpp"
#include "verification/random_scenes/numbers.hpp"
#include "verification/support/scene_text.hpp"
#include "verification/support/support.hpp"
#include "verification/support/texts.hpp"

using namespace freeplay;
using Catch::Matchers::Contains;
using verification::random_scenes::Draw;
using verification::random_scenes::toml;

namespace {

std::string ball(const std::string& keys, double restitution = 0.5) {
  return "gravity = [0, -9.81]\n" + test::body("ball", 0.3, 3e-4, keys) + R"([contacts.table]
type = "plane"
between = ["ground", "ball"]
radius = 0.05
surface = "hard"
[surfaces.hard]
restitution = )" +
         fmt::format("{}\n", restitution) +
         test::run_for(0.4, "start = \"given\"\n[nonsmooth]\nscheme = \"event-driven\"\n");
}

Sensitivities of(const std::string& text, std::vector<std::string> quantities, std::vector<std::string> keys,
                 const std::vector<std::string>& options = {}) {
  return sensitivities(parse_scene(text, "s.toml", options),
                       {.of = std::move(quantities), .to = std::move(keys)});
}

std::string refusal(const std::string& quantity, const std::string& key,
                    const std::vector<std::string>& options = {}) {
  return test::refusal_of<std::exception>(
      [&] { of(ball("position = [0, 0.55]\n"), {quantity}, {key}, options); });
}

/// The reason why the derivative does not exist.
std::string reason(const std::string& text, const std::string& quantity, const std::string& key) {
  const auto s = of(text, {quantity}, {key});
  CHECK(std::isnan(s.quantities[0].derivatives[0]));
  return s.quantities[0].reasons[0];
}

struct RandomCase {
  std::string text;
  std::vector<std::string> quantities, keys;
};

const std::vector<std::string> events{"event.1.t", "event.1.v_n_minus", "event.1.impulse_n", "event.3.t",
                                      "event.3.impulse_n"};

std::vector<std::string> with_events(std::vector<std::string> more) {
  more.insert(more.end(), events.begin(), events.end());
  return more;
}

/// A disc with spin between a floor and two walls.
RandomCase disc_in_box(Draw& r) {
  const double m = r.between(0.1, 2), radius = r.between(0.02, 0.1);
  return {toml(R"(gravity = [{}, {}]
[bodies.disc]
mass = {}
inertia = {}
position = [{}, {}]
velocity = [{}, {}]
angular_velocity = {}
[contacts.floor]
type = 'plane'
between = ['ground', 'disc']
radius = {}
surface = 's'
[contacts.left]
type = 'plane'
between = ['ground', 'disc']
at = [[-0.6, 0], [0, 0]]
axis = [0.1, -1]
radius = {}
surface = 's'
[contacts.right]
type = 'plane'
between = ['ground', 'disc']
at = [[0.6, 0], [0, 0]]
axis = [0.2, 1]
radius = {}
surface = 's'
[surfaces.s]
restitution = {}
friction = {}
[run]
duration = 1.2
start = 'given'
[nonsmooth]
scheme = 'event-driven'
tolerance = 1e-12
)",
               r.between(-2, 2), -r.between(5, 12), m, m * radius * radius * r.between(0.3, 0.6),
               r.between(-0.3, 0.3), r.between(0.2, 0.8), r.between(-2, 2), r.between(-2, 2),
               r.between(-20, 20), radius, radius, radius, r.between(0.5, 0.9), r.between(0.02, 0.6)),
          with_events({"end.disc.x", "end.disc.vy", "end.disc.omega", "energy.dissipated_by_friction",
                       "energy.dissipated_in_contacts", "mean.floor.fn", "mean.disc.y"}),
          {"surfaces.s.restitution", "surfaces.s.friction", "bodies.disc.mass", "bodies.disc.inertia",
           "gravity[1]", "contacts.floor.radius", "bodies.disc.velocity[0]"}};
}

/// A pendulum with a spring between two end stops.
RandomCase stopped_pendulum(Draw& r) {
  return {toml(R"(gravity = [0, {}]
[bodies.bar]
mass = {}
inertia = {}
position = [{}, 0]
[joints.pivot]
type = 'revolute'
between = ['ground', 'bar']
at = [[0, 0], [{}, 0]]
[contacts.stop]
type = 'angle-stop'
joint = 'pivot'
lower = {}
upper = 0.6
radius = 0.2
surface = 's'
[loads.spring]
type = 'spring-damper'
between = ['ground', 'bar']
at = [[0.4, 0.5], [0.1, 0.05]]
stiffness = {}
damping = {}
free_length = 0.4
[surfaces.s]
restitution = {}
[run]
duration = 1.5
[nonsmooth]
scheme = 'event-driven'
tolerance = 1e-12
)",
               -r.between(5, 12), r.between(0.5, 3), r.between(0.02, 0.1), 0.3, -0.3, -r.between(0.5, 1.2),
               r.between(5, 40), r.between(0.1, 1), r.between(0.6, 0.95)),
          with_events({"end.bar.theta", "end.bar.omega", "end.pivot.fy", "mean.pivot.fx",
                       "energy.dissipated_in_dampers"}),
          {"surfaces.s.restitution", "bodies.bar.mass", "bodies.bar.inertia", "contacts.stop.lower",
           "loads.spring.stiffness", "loads.spring.damping", "joints.pivot.at[1][0]", "gravity[1]"}};
}

/// A free journal in a free bearing with friction.
RandomCase ring_and_journal(Draw& r) {
  return {
      toml(R"([bodies.ring]
mass = {}
inertia = 0.01
angular_velocity = {}
[bodies.journal]
mass = {}
inertia = 0.0004
position = [{}, {}]
velocity = [{}, {}]
angular_velocity = {}
[joints.pin]
type = 'revolute'
between = ['ring', 'journal']
at = [[0, 0], [0, 0]]
clearance = 1e-3
bearing_radius = 0.02
surface = 's'
[surfaces.s]
restitution = {}
friction = {}
[run]
duration = 0.02
start = 'given'
[nonsmooth]
scheme = 'event-driven'
tolerance = 1e-12
)",
           r.between(0.5, 3), r.between(-5, 5), r.between(0.2, 1), r.between(-4e-4, 4e-4),
           r.between(-4e-4, 4e-4), r.between(-0.5, 0.5), r.between(-0.5, 0.5), r.between(-30, 30),
           r.between(0.6, 0.95), r.between(0.02, 0.4)),
      with_events(
          {"end.journal.vx", "end.ring.omega", "end.pin.ex", "end.pin.gap", "energy.dissipated_in_contacts"}),
      {"surfaces.s.restitution", "surfaces.s.friction", "joints.pin.clearance", "joints.pin.bearing_radius",
       "bodies.journal.mass", "bodies.ring.inertia", "bodies.journal.velocity[0]"}};
}

/// A driven slider-crank whose gudgeon pin has clearance.
RandomCase slider_crank(Draw& r) {
  return {toml(R"(gravity = [0, -9.81]
[bodies.crank]
mass = 1
inertia = 0.001
[bodies.rod]
mass = {}
inertia = {}
[bodies.slider]
mass = {}
inertia = 0.001
[joints.main]
type = 'revolute'
between = ['ground', 'crank']
at = [[0, 0], [0, 0]]
[joints.big_end]
type = 'revolute'
between = ['crank', 'rod']
at = [[0.05, 0], [-0.15, 0]]
[joints.gudgeon]
type = 'revolute'
between = ['rod', 'slider']
at = [[0.15, 0], [0, 0]]
clearance = {}
bearing_radius = 0.011
surface = 's'
[joints.guide]
type = 'translational'
between = ['ground', 'slider']
axis = [1, 0]
[surfaces.s]
restitution = {}
friction = {}
[drives.motor]
joint = 'main'
speed = {}
[run]
duration = 0.03
start = 'ideal'
[nonsmooth]
scheme = 'event-driven'
tolerance = 1e-12
)",
               r.between(0.5, 2), r.between(0.005, 0.02), r.between(0.5, 2), r.between(1e-4, 5e-4),
               r.between(0.5, 0.9), r.between(0.01, 0.3), r.between(10, 40)),
          with_events(
              {"end.slider.x", "end.slider.vx", "end.rod.omega", "energy.work_of_drives", "end.guide.fy"}),
          {"surfaces.s.restitution", "surfaces.s.friction", "joints.gudgeon.clearance", "bodies.slider.mass",
           "joints.big_end.at[0][0]", "drives.motor.speed"}};
}

/// Values of the quantities with one key displaced by d, relative; keys with an index are set as lists.
std::vector<double> values_at(const RandomCase& c, const std::string& key, double value) {
  auto scene = parse_scene(c.text, "random");
  const auto bracket = key.find('[');
  if (bracket == key.npos) {
    scene.set(key, value);
  } else {
    // The lists of these scenes have numbers only.
    const auto name = key.substr(0, bracket);
    const std::string mark = name.substr(name.rfind('.') + 1) + " = ";
    auto at = c.text.find(name.find('.') == name.npos ? mark : "[" + name.substr(0, name.rfind('.')) + "]");
    at = c.text.find(mark, at) + mark.size();
    auto list = c.text.substr(at, c.text.find('\n', at) - at);
    std::size_t place = 0;
    for (auto b = bracket; b != key.npos; b = key.find('[', b + 1)) {
      place = list.find('[', place) + 1;
      int skip = std::stoi(key.substr(b + 1));
      for (int depth = 0; skip > 0; ++place) {
        depth += (list[place] == '[') - (list[place] == ']');
        skip -= list[place] == ',' && depth == 0;
      }
    }
    place = list.find_first_not_of(' ', place);
    list.replace(place, list.find_first_of(",]", place) - place, fmt::format("{:.17g}", value));
    scene.set(name, list);
  }
  std::vector<double> values;
  for (const auto& q : sensitivities(scene, {.of = c.quantities, .to = {}}).quantities)
    values.push_back(q.value);
  return values;
}

}  // namespace

TEST_CASE("quantities and keys without derivatives are refused", "[sensitivity]") {
  CHECK_THAT(refusal("event.0.t", "bodies.ball.mass"), Contains("event.0.t: must be event.N.t"));
  CHECK_THAT(refusal("end.ball.q", "bodies.ball.mass"), Contains("is no column of trajectory.csv"));
  CHECK_THAT(refusal("peak.a", "bodies.ball.mass"), Contains("peak.a: peaks of instruments"));
  CHECK_THAT(refusal("energy.lost", "bodies.ball.mass"), Contains("dissipated_in_contacts"));
  CHECK_THAT(refusal("end.ball.y", "bodies.ball.weight"), Contains("bodies.ball.weight: has no value"));
  CHECK_THAT(refusal("end.ball.y", "gravity"), Contains("gravity: is not one number"));
  CHECK_THAT(refusal("end.ball.y", "gravity[2]"), Contains("gravity[2]: is not one number"));
  CHECK_THAT(refusal("end.ball.y", "nonsmooth.tolerance"), Contains("is a numerical setting"));
  CHECK_THAT(refusal("end.ball.y", "initial.ball.z"), Contains("must be initial.BODY.PART"));
  CHECK_THAT(
      refusal("end.ball.y", "bodies.ball.mass", {"nonsmooth.scheme=moreau-jean", "nonsmooth.step=1e-4"}),
      Contains("time stepping has no derivatives yet"));
}

TEST_CASE("motions without a derivative are refused with the reason", "[sensitivity]") {
  // at rest on the table
  CHECK_THAT(reason(ball("position = [0, 0.05]\n"), "end.ball.y", "initial.ball.y"),
             Contains("one-sided derivative"));
  CHECK_THAT(reason(ball("position = [0, 0.55]\n"), "event.9.t", "bodies.ball.mass"),
             Contains("the run has 1 contact event"));
  CHECK_THAT(reason(ball("position = [0, 0.55]\n", 1), "end.ball.y", "surfaces.hard.restitution"),
             Contains("values beside 1 are not possible"));
  // A disc with upward acceleration touches the floor at its lowest point.
  auto grazing = ball("position = [0, 0.55]\nvelocity = [0, -3]\n");
  grazing.replace(grazing.find("-9.81"), 5, "8.9999999");
  CHECK_THAT(reason(grazing, "end.ball.y", "initial.ball.vy"), Contains("grazes"));
  // A ball meets two that touch.
  const std::string cradle = test::body("one", 1, 0.004, "position = [-0.25, 0]\nvelocity = [1, 0]\n") +
                             test::body("two", 1, 0.004, "position = [0, 0]\n") +
                             test::body("three", 1, 0.004, "position = [0.2, 0]\n") + R"([contacts.left]
type = "discs"
between = ["one", "two"]
radii = [0.1, 0.1]
surface = "s"
[contacts.right]
type = "discs"
between = ["two", "three"]
radii = [0.1, 0.1]
surface = "s"
[surfaces.s]
restitution = 1
)" + test::run_for(0.1, "start = \"given\"\n[nonsmooth]\nscheme = \"event-driven\"\n");
  CHECK_THAT(reason(cradle, "end.three.vx", "initial.one.vx"), Contains("depends on the order of impacts"));
}

TEST_CASE("tolerances of a drop propagate to the time of contact", "[sensitivity][program]") {
  // t = sqrt(2 h/g): σ_t = t/2 sqrt((σ_h/h)² + (σ_g/g)²). The radius shifts h.
  const double g = 9.81, h = 0.5, sigma_h = 1e-3, sigma_g = 0.02, t = std::sqrt(2 * h / g);
  const auto s = of(ball("position = [0, 0.55]\n"), {"event.1.t"}, {"initial.ball.y", "gravity[1]"});
  CHECK(propagated_deviation(s.quantities[0], {sigma_h, sigma_g}) ==
        Approx(0.5 * t * std::hypot(sigma_h / h, sigma_g / g)).epsilon(1e-8));
  CHECK(propagated_deviation(s.quantities[0], {0, 0}) == 0);
  test::TemporaryFolder folder;
  const auto scene = (folder.path() / "ball.toml").string();
  write_file(scene, ball("position = [0, 0.55]\n"));
  const auto run = [&](const std::string& words) {
    return test::freeplay(
        fmt::format("sensitivity {} --of event.1.t -o {}/out {}", scene, folder.path().string(), words));
  };
  const auto told = run("--spread initial.ball.y=1e-3");
  CHECK(told.status == 0);
  CHECK_THAT(told.out, Contains(fmt::format("standard deviation {:.4g} (first order)", sigma_h / (g * t))));
  CHECK_THAT(run("--spread initial.ball.y").err, Contains("must be KEY=DEVIATION"));
  CHECK_THAT(run("--spread initial.ball.y=-1").err, Contains("must be KEY=DEVIATION"));
  CHECK_THAT(run("").err, Contains("must name at least one key"));
}

TEST_CASE("derivatives of random scenes equal extrapolated differences of runs", "[sensitivity]") {
  constexpr int scenes = 100;
  int compared = 0, refused = 0, unresolved = 0;
  double worst = 0;
  for (int i = 0; i < scenes; ++i) {
    Draw r(20261125, i);
    const auto c = i % 4 == 0   ? disc_in_box(r)
                   : i % 4 == 1 ? stopped_pendulum(r)
                   : i % 4 == 2 ? ring_and_journal(r)
                                : slider_crank(r);
    const auto s = sensitivities(parse_scene(c.text, "random"), {.of = c.quantities, .to = c.keys});
    const auto key = static_cast<std::size_t>(r.between(0, static_cast<double>(c.keys.size()) * 0.999));
    const double p = s.key_values[key], h = 1e-4 * (p != 0 ? std::abs(p) : 1);
    std::vector<std::vector<double>> at;
    for (const double d : {-2.0, -1.0, -0.5, -0.25, 0.25, 0.5, 1.0, 2.0})
      at.push_back(values_at(c, c.keys[key], p + d * 0.25 * h));
    for (std::size_t q = 0; q < c.quantities.size(); ++q) {
      const auto slope = [&](int j, double d) { return (at[7 - j][q] - at[j][q]) / (2 * d * 0.25 * h); };
      const double coarse = (4 * slope(1, 1) - slope(0, 2)) / 3, fine = (4 * slope(2, 0.5) - slope(1, 1)) / 3,
                   finest = (4 * slope(3, 0.25) - slope(2, 0.5)) / 3;
      const double expected = fine + (fine - coarse) / 15, measured = s.quantities[q].derivatives[key];
      const double scale = std::abs(expected) + 1e-3 * std::abs(s.quantities[q].value / (p != 0 ? p : 1));
      if (std::isnan(measured)) {
        CHECK_FALSE(s.quantities[q].reasons[key].empty());
        ++refused;
        continue;
      }
      // Where the differences themselves do not settle, neighbouring runs have other events.
      if (!(std::abs(fine - coarse) < 1e-5 * scale)) {
        ++unresolved;
        continue;
      }
      ++compared;
      // Differences of extrapolations estimate their own error: truncation by the coarse one, noise of the
      // runs by the finest one.
      const double own = std::max(std::abs(fine - coarse), std::abs(finest - fine));
      const double error = std::max(0.0, std::abs(measured - expected) - 2 * own) / scale;
      worst = std::max(worst, error);
      if (!(error < 1e-6)) {
        CAPTURE(i, c.quantities[q], c.keys[key], measured, expected, own, error);
        CHECK(error < 1e-6);
      }
    }
  }
  WARN(fmt::format("{} derivatives compared, greatest error {:.2g}, {} refused, {} unresolved", compared,
                   worst, refused, unresolved));
  CHECK(compared > 500);
}
