// Cams under flat faces and rollers: forces, torques, and the speed from which the follower leaves its cam.
#include <fmt/format.h>

#include <cmath>

#include "facade/simulation.hpp"
#include "io/scene/open_scene.hpp"
#include "verification/claims/claim.hpp"
#include "verification/claims/force_claims.hpp"
#include "verification/references/cam_follower.hpp"
#include "verification/support/support.hpp"
#include "verification/support/ways.hpp"

namespace freeplay::verification {
namespace {

using force_claims::find;

constexpr double step = 1e-5;  // s, of time steps
using test::Way;
const Way ways[] = {test::penalty, test::event_driven, test::automatic,
                    test::fixed_steps(step, "Moreau–Jean at 1e-5 s")};

/// An eccentric cam at `speed`, the follower above it at rest on its lowest place; `profile` and `friction` as keys.
Scene scene_of(const reference::EccentricCam& c, double speed, double turns, const std::string& follower,
               double height, const std::string& profile, const Way& way, const std::string& friction = "") {
  constexpr double gravity = 9.81;
  auto scene = parse_scene(fmt::format(R"(
gravity = [0.0, -9.81]
[bodies.cam]
mass = 1.0
inertia = 1e-3
angular_velocity = {0:.17g}
[bodies.follower]
mass = {1}
inertia = 1e-4
position = [0.0, {2}]
[surfaces.steel]
young = 2e11
poisson = 0.3
restitution = 0.2
{3}
[joints.pin]
type = "revolute"
between = ["ground", "cam"]
[joints.guide]
type = "translational"
between = ["ground", "follower"]
at = [[0.0, {2}], [0.0, 0.0]]
axis = [0.0, 1.0]
[contacts.lobe]
type = "cam"
between = ["cam", "follower"]
{4}
{5}
surface = "steel"
[drives.motor]
joint = "pin"
speed = {0:.17g}
[loads.spring]
type = "spring-damper"
between = ["ground", "follower"]
at = [[0.0, {6}], [0.0, 0.0]]
stiffness = {7}
free_length = 0.5
preload = {8:.17g}
[run]
revolutions = {9}
start = "given"
)",
                                       speed, c.mass, height, friction, follower, profile, height + 0.5,
                                       c.stiffness, -(c.preload - c.mass * gravity), turns),
                           "cam");
  way.choose(scene);
  return scene;
}
std::string eccentric(double e) {
  return fmt::format("law = \"harmonic\"\nlift = {:.17g}\nstart = {:.17g}\nrise = {:.17g}\nreturn = {:.17g}",
                     2 * e, M_PI / 2, M_PI, M_PI);
}
constexpr const char* flat = "follower = \"flat\"\naxis = [-1.0, 0.0]\nbase_radius = 0.03";
constexpr const char* roller = "follower = \"roller\"\nroller_radius = 0.01\nbase_radius = 0.03";

/// Greatest errors of the contact's force over the greatest force, and of the cam's torque over the greatest torque.
struct Off {
  double force = 0, torque = 0;
};
template <class Force, class Torque>
Off off(const Scene& scene, const Way& way, double speed, Force force, Torque torque) {
  Simulation simulation(scene, test::name_of(way.family));
  const auto& layout = simulation.layout();
  const auto lobe = find(layout, "lobe"), motor = find(layout, "motor");
  Forces now{std::vector<ElementForce>(layout.forces.size()), std::vector<double>(6)};
  double most_force = 0, most_torque = 0;
  Off sum;
  test::Listener listener;
  listener.want.forces = true;
  listener.on_step = [&](const Step& s) {
    // Steps start from rest on the cam; a contact that is laid down oscillates on its stiffness first. The last may be short.
    if (way.penalty() && speed * s.t0 < 0.5 * M_PI) return;
    if (way.fixed() && (s.t0 < 1.5 * step || s.t1 > scene.run.duration - 1.5 * step)) return;
    const double t = way.fixed() ? 0.5 * (s.t0 + s.t1) : s.t1, phi = speed * t;
    s.forces(t, now);
    most_force = greatest(most_force, std::abs(force(phi)));
    most_torque = greatest(most_torque, std::abs(torque(phi)));
    sum.force = greatest(sum.force, std::abs(now.elements[lobe].fn - force(phi)));
    sum.torque = greatest(sum.torque, std::abs(now.elements[motor].m - torque(phi)));
  };
  const auto result = test::finished(simulation, {&listener});
  return {sum.force / most_force, sum.torque / most_torque};
}

constexpr const char* source = "references/cam_follower";

/// Greatest height of the follower over its cam (m), at the ends of steps.
double height(const Scene& scene, const reference::EccentricCam& c, double speed) {
  Simulation simulation(scene, "nonsmooth");
  std::vector<double> q(6), v(6);
  double most = 0;
  test::Listener listener;
  listener.on_step = [&](const Step& s) {
    s.state(s.t1, q, v);
    most = greatest(most, q[4] - c.radius - c.lift(speed * s.t1));
  };
  const auto result = test::finished(simulation, {&listener});
  return most;
}

void forces(Findings& f) {
  const double speed = 90, R = 0.03;
  const reference::EccentricCam face{0.01, 0.2, 800, 11.962, R}, rubbing{0.01, 0.2, 800, 11.962, R, 0.15},
      rolling{0.008, 0.2, 800, 11.962, R + 0.01};
  std::string points;
  for (int i = 0; i < 72; ++i) {
    const double angle = 2 * M_PI * i / 72;
    points += fmt::format("{}[{:.17g}, {:.17g}]", i ? ", " : "", angle, face.lift(angle - M_PI / 2));
  }
  const auto table = fmt::format("lift_table = [{}]", points);
  const auto claim = [&](const char* what, const Way& way, const Off& o, double bound, const char* reason) {
    f.at_most(fmt::format("{}, {}: contact force, greatest error over greatest force", what, way.name), "",
              o.force, bound, source, reason);
    f.at_most("its cam's torque, likewise", "", o.torque, bound, source, reason);
  };
  for (const auto& way : ways) {
    const bool soft = way.penalty(), rough = way.fixed();
    const double bound = soft ? 0.02 : rough ? 2e-3 : 1e-7;
    const char* reason =
        soft    ? "contact of 1e-6 m by 1e-2 m of lift, and what its oscillation leaves after a quarter turn"
        : rough ? "a step's mean force is first order: h ω = 9e-4, twice"
                : "tolerance 1e-10 a step, room of a thousand";
    claim("eccentric cam under a flat face", way,
          off(
              scene_of(face, speed, 2, flat, R, eccentric(0.01), way), way, speed,
              [&](double phi) { return face.press(phi, speed); },
              [&](double phi) { return face.torque_flat(phi, speed); }),
          bound, reason);
    claim("the same, friction 0.15", way,
          off(
              scene_of(rubbing, speed, 2, flat, R, eccentric(0.01), way, "friction = 0.15"), way, speed,
              [&](double phi) { return rubbing.press(phi, speed); },
              [&](double phi) { return rubbing.torque_flat(phi, speed); }),
          bound, reason);
    claim("roller on a harmonic pitch curve", way,
          off(
              scene_of(rolling, speed, 2, roller, R + 0.01, eccentric(0.008), way), way, speed,
              [&](double phi) { return rolling.normal_roller(phi, speed); },
              [&](double phi) { return rolling.torque_roller(phi, speed); }),
          bound, reason);
    claim("the eccentric cam by a table of 72 lifts", way,
          off(
              scene_of(face, speed, 2, flat, R, table, way), way, speed,
              [&](double phi) { return face.press(phi, speed); },
              [&](double phi) { return face.torque_flat(phi, speed); }),
          bound + 1e-3, "and h'' of a cubic spline, known to (5°)²/8");
  }
}

void jumps(Findings& f) {
  const double R = 0.03;
  const reference::EccentricCam c{0.01, 0.2, 800, 11.962, R};
  const double jump = c.jump_speed();
  for (const auto& way : ways) {
    const auto losses = [&](double share, double from = 0.5 * M_PI) {
      const auto run =
          test::finished(scene_of(c, share * jump, 3, flat, R, eccentric(0.01), way), way.family);
      std::vector<double> angles;
      for (const auto& e : run.events)
        if (e.kind == EventKind::separation && e.crank_angle > from) angles.push_back(e.crank_angle);
      return angles;
    };
    const bool soft = way.penalty();
    if (way.fixed())
      // What is pressed drifts off by an error of third order a step, until that is more than the force takes back.
      f.at_most(
          fmt::format("at 0.98 of the jump speed, greatest height over the cam in 3 turns, {}", way.name),
          "m", height(scene_of(c, 0.98 * jump, 3, flat, R, eccentric(0.01), way), c, 0.98 * jump), 4e-8,
          source, "hops of a step: h² times what cam and spring accelerate by, 300 m/s²");
    else
      f.at_most(
          fmt::format("at 0.98 of the jump speed, times that the follower leaves its cam in 3 turns, {}",
                      way.name),
          "", static_cast<double>(losses(0.98).size()), 0, source,
          "the least force is 4 % of the preload's and the spring's sum still");
    const auto angles = losses(1.02, way.fixed() ? c.lost_at(1.02 * jump) - 0.01 : 0.5 * M_PI);
    f.within(fmt::format("at 1.02 of it, cam angle of the first loss, {}{}", way.name,
                         way.fixed() ? ", but for hops of a step before" : ""),
             "rad", angles.empty() ? NAN : angles.front(), c.lost_at(1.02 * jump),
             soft          ? 0.05
             : way.fixed() ? 0.01
                           : 1e-6,
             source,
             soft          ? "unloading a contact of 5e3/s takes 2e-4 s, twice"
             : way.fixed() ? "h ω = 1.2e-3 rad, and the force is first order"
                           : "tolerance 1e-10, and a force that falls by 3e3 N/s");
  }
  // cases/cam-follower: well above it.
  const double speed = 1300 * 2 * M_PI / 60;
  const auto landing = c.landing(speed);
  for (const auto& way : ways) {
    const auto run = test::finished(scene_of(c, speed, 1, flat, R, eccentric(0.01), way), way.family);
    const bool soft = way.penalty();
    const double off = soft ? 1e-3 : way.fixed() ? 3e-4 : 1e-7;
    const char* reason = soft ? "as it leaves 0.05 rad late at the most, with 1e-3 of its speed more or less"
                         : way.fixed() ? "leaves a step late, 1e-3 rad; lands in whole steps"
                                       : "tolerance 1e-10";
    double t = NAN, rate = NAN;
    for (const auto& e : run.events)
      if (e.kind != EventKind::separation && e.crank_angle > 0.5 * M_PI &&
          !(way.fixed() && e.v_n_minus > -1e-3)) {
        t = e.t, rate = e.v_n_minus;
        break;
      }
    f.relative(fmt::format("follower that leaves its cam at 1300 rpm, time of its landing, {}", way.name),
               "s", t, c.lost_at(speed) / speed + landing.after, off, source, reason);
    f.relative(fmt::format("the rate of its landing, {}", way.name), "m/s", rate, landing.rate, 10 * off,
               source, "an acceleration of 600 m/s² on the cam times that error of time");
  }
}

}  // namespace

Findings cams() {
  Findings f;
  forces(f);
  jumps(f);
  return f;
}

}  // namespace freeplay::verification
