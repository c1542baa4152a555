// Cams with flat-faced and roller followers: contact force, cam torque, and the speed at which the
// follower lifts off.
#include "io/scene/read_scene.hpp"
#include "verification/claims/claim.hpp"
#include "verification/claims/force_claims.hpp"
#include "verification/references/cam_follower.hpp"
#include "verification/support/runs.hpp"

namespace freeplay::verification {
namespace {

using force_claims::find;

constexpr double step = 1e-5;  // s, of time steps
using test::Way;
const Way ways[] = {test::penalty, test::event_driven, test::automatic,
                    test::fixed_steps(step, "Moreau–Jean, h = 1e-5 s")};

/// An eccentric cam at `speed`, its follower at rest at the lowest position; `profile` and
/// `friction` are keys of the scene.
Scene scene_of(const reference::EccentricCam& c, double speed, double turns, const std::string& follower,
               double height, const std::string& profile, const Way& way, const std::string& friction = "") {
  constexpr double gravity = 9.81;
  auto scene = parse_scene(
      "gravity = [0.0, -9.81]\n" +
          test::body("cam", 1.0, 1e-3, fmt::format("angular_velocity = {:.17g}\n", speed)) +
          test::body("follower", c.mass, 1e-4, fmt::format("position = [0.0, {}]\n", height)) +
          fmt::format("[surfaces.steel]\nyoung = 2e11\npoisson = 0.3\nrestitution = 0.2\n{}\n", friction) +
          test::pin("pin", "ground", "cam") +
          test::guide("guide", "ground", "follower", {0.0, 1.0}, {0.0, height}, {}) +
          fmt::format("[contacts.lobe]\ntype = \"cam\"\nbetween = [\"cam\", \"follower\"]\n{}\n{}\n"
                      "surface = \"steel\"\n",
                      follower, profile) +
          test::motor("motor", "pin", speed) +
          test::spring("spring", "ground", "follower", {0.0, height + 0.5}, {}, c.stiffness, 0.5,
                       fmt::format("preload = {:.17g}\n", -(c.preload - c.mass * gravity))) +
          fmt::format("[run]\nrevolutions = {}\nstart = \"given\"\n", turns),
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

/// Greatest errors of the contact's force over the greatest force, and of the cam's torque over the
/// greatest torque.
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
  const auto result = test::watch_steps(simulation, [&](const Step& s) {
    // The contact starts without compression, so that it oscillates on its stiffness first; the
    // last step may be short.
    if (way.penalty() && speed * s.t0 < 0.5 * M_PI) return;
    if (way.fixed() && (s.t0 < 1.5 * step || s.t1 > scene.run.duration - 1.5 * step)) return;
    const double t = way.fixed() ? 0.5 * (s.t0 + s.t1) : s.t1, phi = speed * t;
    s.forces(t, now);
    most_force = greatest(most_force, std::abs(force(phi)));
    most_torque = greatest(most_torque, std::abs(torque(phi)));
    sum.force = greatest(sum.force, std::abs(now.elements[lobe].fn - force(phi)));
    sum.torque = greatest(sum.torque, std::abs(now.elements[motor].m - torque(phi)));
  });
  return {sum.force / most_force, sum.torque / most_torque};
}

constexpr const char* source = "references/cam_follower";

/// Greatest height of the follower over its cam (m), at the ends of steps.
double height(const Scene& scene, const reference::EccentricCam& c, double speed) {
  Simulation simulation(scene, "nonsmooth");
  std::vector<double> q(6), v(6);
  double most = 0;
  test::watch_steps(simulation, [&](const Step& s) {
    s.state(s.t1, q, v);
    most = greatest(most, q[4] - c.radius - c.lift(speed * s.t1));
  });
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
    f.at_most(claim_name(what, "contact force, greatest error over greatest force", way.name), "", o.force,
              bound, source, reason);
    f.at_most(claim_name(what, "cam torque, greatest error over greatest torque", way.name), "", o.torque,
              bound, source, reason);
  };
  for (const auto& way : ways) {
    const bool soft = way.penalty(), rough = way.fixed();
    const double bound = soft ? 0.02 : rough ? 2e-3 : 1e-7;
    const char* reason = soft    ? "penetration of 1e-6 m over a lift of 1e-2 m, "
                                   "and its remaining oscillation after a quarter turn"
                         : rough ? "the mean force of a step is of first order: h ω = 9e-4, margin of two"
                                 : "tolerance 1e-10 per step, margin of 1000";
    claim("eccentric cam, flat-faced follower", way,
          off(
              scene_of(face, speed, 2, flat, R, eccentric(0.01), way), way, speed,
              [&](double phi) { return face.press(phi, speed); },
              [&](double phi) { return face.torque_flat(phi, speed); }),
          bound, reason);
    claim("eccentric cam, flat-faced follower, friction 0.15", way,
          off(
              scene_of(rubbing, speed, 2, flat, R, eccentric(0.01), way, "friction = 0.15"), way, speed,
              [&](double phi) { return rubbing.press(phi, speed); },
              [&](double phi) { return rubbing.torque_flat(phi, speed); }),
          bound, reason);
    claim("harmonic cam, roller follower", way,
          off(
              scene_of(rolling, speed, 2, roller, R + 0.01, eccentric(0.008), way), way, speed,
              [&](double phi) { return rolling.normal_roller(phi, speed); },
              [&](double phi) { return rolling.torque_roller(phi, speed); }),
          bound, reason);
    claim("eccentric cam by a table of 72 lifts, flat-faced follower", way,
          off(
              scene_of(face, speed, 2, flat, R, table, way), way, speed,
              [&](double phi) { return face.press(phi, speed); },
              [&](double phi) { return face.torque_flat(phi, speed); }),
          bound + 1e-3, "error of the eccentric cam, and (5°)²/8 of the cubic spline's second derivative");
  }
}

void jumps(Findings& f) {
  const double R = 0.03;
  const reference::EccentricCam c{0.01, 0.2, 800, 11.962, R};
  const double jump = c.jump_speed();
  const char* const below = "eccentric cam at 0.98 of the jump speed";
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
      // A closed contact drifts open by a third-order error per step, until the contact force
      // closes it again.
      f.at_most(claim_name(below, "greatest height of the follower over the cam in 3 turns", way.name), "m",
                height(scene_of(c, 0.98 * jump, 3, flat, R, eccentric(0.01), way), c, 0.98 * jump), 4e-8,
                source, "separations of one step: h² times the acceleration by cam and spring, 300 m/s²");
    else
      f.at_most(claim_name(below, "separations in 3 turns", way.name), "",
                static_cast<double>(losses(0.98).size()), 0, source,
                "exact: the least contact force is still 4 % of preload and spring force");
    const auto angles = losses(1.02, way.fixed() ? c.lost_at(1.02 * jump) - 0.01 : 0.5 * M_PI);
    f.within(
        claim_name("eccentric cam at 1.02 of the jump speed", "cam angle of the first separation", way.name),
        "rad", angles.empty() ? NAN : angles.front(), c.lost_at(1.02 * jump),
        soft          ? 0.05
        : way.fixed() ? 0.01
                      : 1e-6,
        source,
        soft ? "unloading of a contact with 5e3/s takes 2e-4 s, margin of two"
        : way.fixed()
            ? "h ω = 1.2e-3 rad, and the force is of first order; earlier separations of one step are ignored"
            : "tolerance 1e-10, and a force that falls by 3e3 N/s");
  }
  // cases/cam-follower: well above the jump speed.
  const double speed = 1300 * 2 * M_PI / 60;
  const auto landing = c.landing(speed);
  for (const auto& way : ways) {
    const auto run = test::finished(scene_of(c, speed, 1, flat, R, eccentric(0.01), way), way.family);
    const bool soft = way.penalty();
    const double off = soft ? 1e-3 : way.fixed() ? 3e-4 : 1e-7;
    const char* reason = soft          ? "separation at most 0.05 rad late, at a speed within 1e-3"
                         : way.fixed() ? "separation a step late, 1e-3 rad; landing in whole steps"
                                       : "tolerance 1e-10";
    double t = NAN, rate = NAN;
    for (const auto& e : run.events)
      if (e.kind != EventKind::separation && e.crank_angle > 0.5 * M_PI &&
          !(way.fixed() && e.v_n_minus > -1e-3)) {
        t = e.t, rate = e.v_n_minus;
        break;
      }
    f.relative(claim_name("eccentric cam at 1300 rpm, above the jump speed", "time of landing", way.name),
               "s", t, c.lost_at(speed) / speed + landing.after, off, source, reason);
    f.relative(claim_name("eccentric cam at 1300 rpm, above the jump speed", "gap rate at landing", way.name),
               "m/s", rate, landing.rate, 10 * off, source,
               "acceleration 600 m/s² at the cam times the bound of the time");
  }
}

}  // namespace

Parts cams() { return {forces, jumps}; }

}  // namespace freeplay::verification
