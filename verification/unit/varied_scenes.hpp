// Random scenes whose derivatives are compared with Richardson-extrapolated differences of whole runs.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <string>
#include <vector>

#include "facade/sensitivity.hpp"
#include "mechanism/scene.hpp"
#include "verification/random_scenes/numbers.hpp"

namespace freeplay::test::varied {

using verification::random_scenes::Draw;
using verification::random_scenes::toml;

struct RandomCase {
  std::string text;
  std::vector<std::string> quantities, keys;
};

inline const std::vector<std::string> events{"event.1.t", "event.1.v_n_minus", "event.1.impulse_n",
                                             "event.3.t", "event.3.impulse_n"};

inline std::vector<std::string> with_events(std::vector<std::string> more) {
  more.insert(more.end(), events.begin(), events.end());
  return more;
}

/// A disc with spin between a floor and two walls.
inline RandomCase disc_in_box(Draw& r) {
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
inline RandomCase stopped_pendulum(Draw& r) {
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
inline RandomCase ring_and_journal(Draw& r) {
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
inline RandomCase slider_crank(Draw& r) {
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
inline std::vector<double> values_at(const RandomCase& c, const std::string& key, double value,
                                     const std::string& formulation) {
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
  for (const auto& q :
       sensitivities(scene, {.of = c.quantities, .to = {}, .formulation = formulation}).quantities)
    values.push_back(q.value);
  return values;
}

inline RandomCase random_case(int i, Draw& r) {
  return i % 4 == 0   ? disc_in_box(r)
         : i % 4 == 1 ? stopped_pendulum(r)
         : i % 4 == 2 ? ring_and_journal(r)
                      : slider_crank(r);
}

struct Compared {
  int compared = 0;
  std::string summary;
};

/// Compares the derivatives of `scenes` random cases with respect to one random key each; `bound_of`: relative
/// bound for a key.
template <class MakeCase, class BoundOf>
Compared compare_random(int scenes, unsigned seed, MakeCase make_case, const std::string& formulation,
                        BoundOf bound_of) {
  int compared = 0, refused = 0, unresolved = 0;
  double worst = 0;
  for (int i = 0; i < scenes; ++i) {
    Draw r(seed, i);
    const auto c = make_case(i, r);
    const auto s = sensitivities(parse_scene(c.text, "random"),
                                 {.of = c.quantities, .to = c.keys, .formulation = formulation});
    const auto key = static_cast<std::size_t>(r.between(0, static_cast<double>(c.keys.size()) * 0.999));
    const double p = s.key_values[key], h = 1e-4 * (p != 0 ? std::abs(p) : 1);
    std::vector<std::vector<double>> at;
    for (const double d : {-2.0, -1.0, -0.5, -0.25, 0.25, 0.5, 1.0, 2.0})
      at.push_back(values_at(c, c.keys[key], p + d * 0.25 * h, formulation));
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
      const double bound = bound_of(c.keys[key]);
      if (!(error < bound)) {
        CAPTURE(i, c.quantities[q], c.keys[key], measured, expected, own, error);
        CHECK(error < bound);
      }
    }
  }
  return {compared, fmt::format("{} derivatives compared, greatest error {:.2g}, {} refused, {} unresolved",
                                compared, worst, refused, unresolved)};
}

}  // namespace freeplay::test::varied
