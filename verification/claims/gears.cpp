// Gears, racks, pins in slots, end stops: rattle, ratios, reactions along the line of action, and what the involute keeps.
#include <fmt/format.h>

#include <array>
#include <cmath>
#include <stdexcept>

#include "facade/simulation.hpp"
#include "model/scene.hpp"
#include "verification/claims/claim.hpp"
#include "verification/references/gears.hpp"
#include "verification/support.hpp"

namespace freeplay::verification {
namespace {

constexpr double alpha = 20 * M_PI / 180;

/// A way to run a scene, and what it can be held to.
struct Way {
  const char* name;
  Family family;
  Scheme scheme;
  double step;    ///< s, 0: chosen
  double speeds;  ///< relative error of speeds and impulses
  const char* reason;
};
const std::array<Way, 4> ways{
    Way{"penalty", Family::penalty, Scheme::moreau_jean, 0, 1e-6,
        "\"exact\" delivers e whatever the stiffness; tolerance 1e-10 in the some ten steps of a contact"},
    Way{"Moreau–Jean at 1e-6 s", Family::nonsmooth, Scheme::moreau_jean, 1e-6, 1e-11,
        "no force between blows: rounding"},
    Way{"event-driven", Family::nonsmooth, Scheme::event_driven, 0, 1e-11,
        "no force between blows: rounding"},
    Way{"automatic", Family::nonsmooth, Scheme::automatic, 0, 1e-11, "no force between blows: rounding"}};

Scene scene_by(const std::string& text, const Way& way) {
  auto scene = parse_scene("format = 2\n" + text, "gears");
  scene.penalty.contact = ContactLaw::exact;
  scene.penalty.tolerance = 1e-10;
  scene.nonsmooth.scheme = way.scheme;
  scene.nonsmooth.step.reset();
  if (way.step > 0) scene.nonsmooth.step = way.step;
  return scene;
}

Result finished(const Scene& scene, const Way& way) {
  auto run = test::simulate(scene, way.family);
  if (run.ending.status != Ending::Status::finished) throw std::runtime_error(run.ending.reason);
  return run;
}

/// Blows of a run against those of a closed form: each one's impulse and approach, and its time.
void blows(Findings& f, const std::string& what, const Way& way, const Result& run,
           const std::vector<reference::Blow>& exact, double e) {
  const auto found = test::touches(run);
  double off = found.size() == exact.size() ? 0 : NAN, late = 0, told = 0;
  for (std::size_t k = 0; k < found.size() && k < exact.size(); ++k) {
    off = greatest(off, std::abs(found[k].impulse_n / exact[k].impulse - 1));
    off = greatest(off, std::abs(-found[k].v_n_minus / exact[k].approach - 1));
    told += way.step > 0 ? way.step : found[k].t_uncertainty;
    const double rounding = 1e-15 * static_cast<double>(k + 1) / exact.back().approach;
    late = greatest(late, std::abs(found[k].t - exact[k].t) / ((1 + 1 / e) * told + rounding));
  }
  f.at_most(fmt::format("{}, {}: {} blows' approach and impulse, greatest relative error", what, way.name,
                        exact.size()),
            "", off, way.speeds, "Newton's impact law", way.reason);
  if (way.family == Family::nonsmooth)
    f.at_most(
        "their times, error over what is told", "", late, 1, "flights at constant speed",
        "what is told of each (Moreau–Jean: a step), a blow late by δ shifts the next by δ/e and itself; rounding of "
        "lengths below 1 m, 1e-15 m over the slowest speed");
}

std::string pair_of_gears(const std::string& mesh, const std::string& more) {
  return R"([bodies.pinion]
mass = 1.0
inertia = 0.001
angular_velocity = 10.0
[bodies.wheel]
mass = 2.0
inertia = 0.004
position = [0.15, 0.0]
[joints.front]
type = "revolute"
between = ["ground", "pinion"]
[joints.rear]
type = "revolute"
between = ["ground", "wheel"]
at = [[0.15, 0.0], [0.0, 0.0]]
[joints.mesh]
type = "gear"
between = ["pinion", "wheel"]
teeth = [20, 40]
module = 5e-3
)" + mesh +
         R"([surfaces.steel]
restitution = 0.6
)" + more;
}
const char* const loose_teeth = "backlash = 1e-4\nmesh_stiffness = 2e10\nsurface = \"steel\"\n";

void rattle(Findings& f) {
  const double r1 = 0.05 * std::cos(alpha), r2 = 0.1 * std::cos(alpha), e = 0.6;
  const reference::GearPair gears{0.001, 0.004, r1, r2};
  const auto exact = reference::bounces(0.5e-4, 1e-4, 10 * r1, e, gears.mass(), 5);
  const double flight = 1e-4 / (10 * r1 * std::pow(e, 5));
  for (const auto& way : ways) {
    auto scene = scene_by(pair_of_gears(loose_teeth, "[run]\nduration = 1\nstart = \"given\"\n"), way);
    scene.run.duration = exact.back().t + 0.5 * flight;
    const auto run = finished(scene, way);
    blows(f, "gears rattle", way, run, exact, e);
    // P alternates between the flanks.
    double sum = 0;
    for (std::size_t k = 0; k < exact.size(); ++k) sum += (k % 2 == 0 ? 1 : -1) * exact[k].impulse;
    f.relative("the pinion's speed after them", "rad/s", run.final_state.v[2], 10 - r1 * sum / gears.J1,
               10 * way.speeds, "ω₁ − Σ ± r₁ P/J₁", "five blows");
    f.relative("the wheel's", "rad/s", run.final_state.v[5], -r2 * sum / gears.J2, 10 * way.speeds,
               "−Σ ± r₂ P/J₂", "five blows");
  }
}

/// Forces at the end of the third step, by name.
ElementForce force_of(const Scene& scene, Family family, const std::string& name) {
  Simulation simulation(scene, test::name_of(family));
  const auto& elements = simulation.layout().forces;
  ElementForce found;
  int steps = 0;
  test::Listener listener;
  listener.want.forces = true;
  Forces now;
  listener.on_step = [&](const Step& step) {
    if (++steps > 3) return;
    step.forces(0.5 * (step.t0 + step.t1), now);
    for (std::size_t k = 0; k < elements.size(); ++k)
      if (elements[k].name == name) found = now.elements[k];
  };
  const auto run = simulation.run({.observers = {&listener}});
  if (run.ending.status != Ending::Status::finished) throw std::runtime_error(run.ending.reason);
  return found;
}

/// An ideal pair under torques: reactions along the line of action, either flank.
void reactions(Findings& f) {
  const double r1 = 0.05 * std::cos(alpha), r2 = 0.1 * std::cos(alpha);
  for (const int side : {1, -1}) {
    const double M1 = 3.0 * side, M2 = 1.0 * side;
    // r₁ ω₁ + r₂ ω₂ = 0: J₁ α₁ = M₁ − s r₁ F, J₂ α₂ = M₂ − s r₂ F.
    const double F = side * (r1 * M1 / 0.001 + r2 * M2 / 0.004) / (r1 * r1 / 0.001 + r2 * r2 / 0.004);
    for (const auto& way : ways) {
      auto scene = scene_by(
          pair_of_gears(
              side > 0 ? "" : "flank = \"backward\"\n",
              fmt::format("[loads.a]\ntype = \"torque\"\nbody = \"pinion\"\ntorque = {}\n[loads.b]\ntype = "
                          "\"torque\"\nbody = \"wheel\"\ntorque = {}\n[run]\nduration = 0.01\n",
                          M1, M2)),
          way);
      const auto at = force_of(scene, way.family, "front"), mesh = force_of(scene, way.family, "mesh");
      const double bound = way.step > 0 ? 1e-7 : 1e-9;
      const char* why = way.step > 0 ? "rounding of velocities, 1e-15 m/s, over a step, and room"
                                     : "constant forces: rounding over steps of 1e-4 s";
      const auto off = [&](const ElementForce& e, double fx, double fy) {
        return std::hypot(e.fx - fx, e.fy - fy) / F;
      };
      const std::string name =
          fmt::format("ideal gears under torques, {} flank, {}", side > 0 ? "forward" : "backward", way.name);
      f.at_most(name + ": force of the mesh on the wheel, error over it", "",
                off(mesh, F * std::sin(alpha), side * F * std::cos(alpha)), bound,
                "Newton and Euler by hand, F along u", why);
      f.at_most("the pinion's bearing, likewise", "",
                off(at, F * std::sin(alpha), side * F * std::cos(alpha)), bound,
                "it stands still: what the mesh does to it, opposite", why);
    }
  }
}

/// Sun, planet on a carrier, fixed ring: the carrier's speed by Willis' formula, turn after turn.
void planet(Findings& f) {
  const std::string text = R"([bodies.sun]
mass = 1.0
inertia = 0.001
angular_velocity = 30.0
[bodies.carrier]
mass = 1.0
inertia = 0.01
angular_velocity = 7.5
[bodies.planet]
mass = 0.5
inertia = 0.0005
position = [0.1, 0.0]
velocity = [0.0, 0.75]
angular_velocity = -15.0
[joints.sun_pin]
type = "revolute"
between = ["ground", "sun"]
[joints.carrier_pin]
type = "revolute"
between = ["ground", "carrier"]
[joints.planet_pin]
type = "revolute"
between = ["carrier", "planet"]
at = [[0.1, 0.0], [0.0, 0.0]]
[joints.inner]
type = "gear"
between = ["sun", "planet"]
teeth = [20, 20]
module = 5e-3
MORE[joints.outer]
type = "gear"
between = ["ground", "planet"]
teeth = [60, 20]
module = 5e-3
internal = true
MORE[surfaces.steel]
restitution = 0.2
[drives.motor]
joint = "sun_pin"
speed = 30.0
[run]
duration = 3.0
start = "assembled"
)";
  const auto with = [&](const std::string& more) {
    auto s = text;
    for (auto at = s.find("MORE"); at != s.npos; at = s.find("MORE")) s.replace(at, 4, more);
    return s;
  };
  const double carrier = 30.0 * 20 / 80 * 3;
  for (const auto& way : ways) {
    auto scene = scene_by(with(""), way);
    if (way.step > 0) scene.nonsmooth.step = 1e-4;
    const auto end = finished(scene, way).final_state;
    const double bound = way.family == Family::penalty ? 1e-7 : 1e-10;
    const char* why = way.family == Family::penalty ? "drift at α = β = 5, 1e-8 m over 0.05 m at most"
                                                    : "positions brought back to rounding each step";
    f.within(fmt::format("planetary gear, ring fixed, ten turns of the sun and more, {}: carrier", way.name),
             "rad", end.q[5], carrier, bound, "Willis: ω_c = ω_s z_s/(z_s + z_r)", why);
    f.within("its planet", "rad", end.q[8], -2 * carrier, bound, "ω_p = ω_c (1 − z_r/z_p)", why);
  }
  for (const auto& way : ways) {
    auto scene = scene_by(with("backlash = 1e-4\nmesh_stiffness = 2e8\nsurface = \"steel\"\n"), way);
    if (way.step > 0) scene.nonsmooth.step = 2e-5;
    scene.run.duration = 1;
    const auto end = finished(scene, way).final_state;
    // Mid-play at the start; each mesh gives half its backlash, and a hair of penetration.
    f.within(fmt::format("with backlash, five turns of the sun, {}: carrier", way.name), "rad", end.q[5],
             carrier / 3, (1e-4 + 1e-6) / (4 * 0.05 * std::cos(alpha)), "Willis",
             "both meshes within half their backlash: 2 (b/2)/(r_b (z_s + z_r)/z_s), and a hundredth");
  }
}

/// A wheel whose centre swings on a spring: the involute's own relation between distance and angles.
void distance(Findings& f) {
  const std::string text = R"([bodies.pinion]
mass = 1.0
inertia = 0.001
angular_velocity = 30.0
[bodies.hub]
mass = 1.0
inertia = 0.01
position = [0.151, 0.0]
velocity = [0.05, 0.0]
[bodies.wheel]
mass = 2.0
inertia = 0.004
position = [0.151, 0.0]
velocity = [0.05, 0.0]
angular_velocity = -15.0
[joints.front]
type = "revolute"
between = ["ground", "pinion"]
[joints.guide]
type = "translational"
between = ["ground", "hub"]
[joints.rear]
type = "revolute"
between = ["hub", "wheel"]
[joints.mesh]
type = "gear"
between = ["pinion", "wheel"]
teeth = [20, 40]
module = 5e-3
[loads.spring]
type = "spring-damper"
between = ["ground", "hub"]
at = [[0.35, 0.0], [0.0, 0.0]]
stiffness = 30000.0
free_length = 0.2
[run]
duration = 0.5
start = "assembled"
)";
  const long double S = 0.15L * std::cos(20 * M_PIl / 180);
  for (const auto& way : ways) {
    auto scene = scene_by(text, way);
    if (way.step > 0) scene.nonsmooth.step = 1e-4;
    if (way.family == Family::penalty) scene.penalty.tolerance = 1e-12;
    double worst = 0;
    test::Listener listener;
    std::vector<double> q(9), v(9);
    double least = 1, most = 0;
    listener.on_step = [&](const Step& step) {
      step.state(step.t1, q, v);
      const long double a = q[6];
      least = std::min(least, q[6]), most = std::max(most, q[6]);
      const long double turned = S / 3 * q[2] + 2 * S / 3 * q[8];
      worst = greatest(worst,
                       double(std::abs(turned - reference::involute(S, a) + reference::involute(S, 0.151L))));
    };
    Simulation simulation(scene, test::name_of(way.family));
    const auto run = simulation.run({.observers = {&listener}});
    if (run.ending.status != Ending::Status::finished) throw std::runtime_error(run.ending.reason);
    const std::string name = fmt::format("gears whose distance swings, {}", way.name);
    f.at_most(name + ": S inv α = r₁ θ₁ + r₂ θ₂, greatest error", "m", worst,
              way.family == Family::penalty ? 1e-9 : 1e-12, "the involute function",
              way.family == Family::penalty ? "drift at α = β = 5, as of all joints"
                                            : "positions are brought back");
    f.between("the same: how far the distance swings", "m", most - least, 5e-4, 0.01, "",
              "it does move: 0.05 m/s against 100 rad/s");
    const auto& l = run.ledger;
    f.at_most("the same: change of the energy over it", "",
              std::abs((l.kinetic + l.potential) / l.initial - 1), way.step > 0 ? 2e-4 : 1e-7,
              "no force does work",
              way.step > 0 ? "the midpoint rule's energy swings by (ω h)² with the spring, and room of two"
                           : "tolerance in each of some thousand steps");
  }
}

std::string rack(const std::string& mesh, const std::string& more) {
  return R"([bodies.pinion]
mass = 1.0
inertia = 0.001
angular_velocity = 10.0
[bodies.bar]
mass = 2.0
inertia = 0.004
position = [0.3, -0.05]
[joints.front]
type = "revolute"
between = ["ground", "pinion"]
[joints.guide]
type = "translational"
between = ["ground", "bar"]
at = [[0.0, -0.05], [0.0, 0.0]]
[joints.mesh]
type = "rack"
between = ["pinion", "bar"]
pitch_radius = 0.05
module = 5e-3
)" + mesh +
         R"([surfaces.steel]
restitution = 0.6
)" + more;
}

void racks(Findings& f) {
  const double r = 0.05, base = r * std::cos(alpha), e = 0.6;
  // Along the line of action a bar counts m/cos²α.
  const double mass = 1 / (base * base / 0.001 + std::cos(alpha) * std::cos(alpha) / 2.0);
  const auto exact = reference::bounces(0.5e-4, 1e-4, 10 * base, e, mass, 5);
  const double flight = 1e-4 / (10 * base * std::pow(e, 5)), M = 2.0, a = M / r / (0.001 / (r * r) + 2.0);
  for (const auto& way : ways) {
    auto scene = scene_by(rack(loose_teeth, "[run]\nduration = 1\nstart = \"given\"\n"), way);
    scene.run.duration = exact.back().t + 0.5 * flight;
    blows(f, "gear and rack rattle", way, finished(scene, way), exact, e);
    scene = scene_by(
        rack("",
             fmt::format(
                 "[loads.a]\ntype = \"torque\"\nbody = \"pinion\"\ntorque = {}\n[run]\nduration = 0.1\n", M)),
        way);
    if (way.step > 0) scene.nonsmooth.step = 1e-5;
    const auto end = finished(scene, way).final_state;
    const double bound = way.family == Family::penalty ? 1e-8 : 1e-11;
    f.within(
        fmt::format("ideal rack under a torque, {}: its speed", way.name), "m/s", end.v[3], r * end.v[2],
        bound, "v = r ω",
        way.family == Family::penalty ? "drift of the rates at α = β = 5" : "rows hold at every step's end");
    scene.run.duration = 0.001;
    const auto at = force_of(scene, way.family, "front");
    f.at_most("the same: the gear's bearing, error over the force", "",
              std::hypot(at.fx - 2 * a, at.fy + 2 * a * std::tan(alpha)) / (2 * a),
              way.step > 0 ? 1e-7 : 1e-9, "m a along the rack and m a tan α across it",
              "constant forces: rounding, and room");
  }
}

void slots(Findings& f) {
  const double r = 0.05, w = 20, phi = 0.7, c = 1e-4;
  const std::string text = fmt::format(R"([bodies.crank]
mass = 1.0
inertia = 0.001
angle = {0}
angular_velocity = 20.0
[bodies.yoke]
mass = 2.0
inertia = 0.004
position = [{1}, 0.0]
velocity = [{2}, 0.0]
[joints.main]
type = "revolute"
between = ["ground", "crank"]
[joints.guide]
type = "translational"
between = ["ground", "yoke"]
[joints.pin]
type = "slot"
between = ["yoke", "crank"]
at = [[0.0, 0.0], [0.05, 0.0]]
axis = [0.0, 1.0]
PLAY[surfaces.steel]
young = 2e11
poisson = 0.3
restitution = 0.6
[drives.motor]
joint = "main"
speed = 20.0
[run]
duration = 0.1
start = "given"
)",
                                       phi, r * std::cos(phi), -r * w * std::sin(phi));
  const auto with = [&](const char* play) {
    auto s = text;
    return s.replace(s.find("PLAY"), 4, play);
  };
  const double t = reference::pin_flight(r, w, phi, c, 0.04);
  const double approach = r * w * std::abs(std::sin(phi + w * t) - std::sin(phi));
  for (const auto& way : ways) {
    auto scene = scene_by(with("clearance = 1e-4\npin_radius = 8e-3\nsurface = \"steel\"\n"), way);
    scene.run.duration = t + 3e-3;  // the whole contact, under a contact law
    const auto touch = test::touch(finished(scene, way), 0);
    const bool stepped = way.step > 0, chosen = way.scheme == Scheme::automatic;
    f.within(fmt::format("Scotch yoke with a loose pin, {}: its first flight", way.name), "s", touch.t, t,
             stepped  ? way.step
             : chosen ? touch.t_uncertainty + 1e-9
                      : 1e-9,
             "r cos φ against uniform motion",
             stepped  ? "a step"
             : chosen ? "what is told"
                      : "tolerance 1e-10 in each of some tens of steps");
    f.relative("the same: approach", "m/s", -touch.v_n_minus, approach, stepped || chosen ? 1e-4 : 1e-7,
               "r ω |sin(φ + ω t) − sin φ|",
               stepped  ? "r ω² times a step"
               : chosen ? "r ω² times what is told"
                        : "tolerance");
    if (way.family == Family::nonsmooth)
      f.relative("the same: impulse", "N s", touch.impulse_n, 1.6 * 2.0 * -touch.v_n_minus,
                 stepped || chosen ? 1e-4 : 1e-9, "(1 + e) m u: the crank is driven",
                 stepped || chosen ? "a step's own force" : "rounding");
    scene = scene_by(with(""), way);
    if (way.step > 0) scene.nonsmooth.step = 1e-5;
    const auto end = finished(scene, way).final_state;
    const double angle = phi + w * 0.1;
    f.within(fmt::format("ideal Scotch yoke, {}: yoke", way.name), "m", end.q[3], r * std::cos(angle),
             way.family == Family::penalty ? 1e-9 : 1e-11, "x = r cos φ",
             way.family == Family::penalty ? "drift at α = β = 5" : "positions are brought back");
  }
}

void stops(Findings& f) {
  const std::string slide = R"([bodies.block]
mass = 2.0
inertia = 0.01
velocity = [1.5, 0.0]
[joints.guide]
type = "translational"
between = ["ground", "block"]
[contacts.end]
type = "travel-stop"
joint = "guide"
lower = -0.1
upper = 0.2
stiffness = 1e11
surface = "rubber"
[surfaces.rubber]
restitution = 0.7
[run]
duration = 1
start = "given"
)";
  const double e = 0.7;
  const auto exact = reference::bounces(0.2, 0.3, 1.5, e, 2.0, 4);
  for (const auto& way : ways) {
    auto scene = scene_by(slide, way);
    scene.run.duration = exact.back().t + 0.1;
    if (way.step > 0) scene.nonsmooth.step = 1e-4;
    auto by = way;
    if (by.step > 0) by.step = 1e-4;
    blows(f, "block between end stops", by, finished(scene, way), exact, e);
  }
  // A rod on a pin against a stop, at its centre of percussion and nearer: what the pin feels.
  const double l = 0.1, Jc = 0.01, JO = Jc + l * l, w = 10, limit = 0.5, er = 0.6, T = 0.06;
  for (const double radius : {JO / l, 0.05}) {
    const auto text = fmt::format(R"([bodies.rod]
mass = 1.0
inertia = 0.01
position = [0.1, 0.0]
velocity = [0.0, 1.0]
angular_velocity = 10.0
[joints.pin]
type = "revolute"
between = ["ground", "rod"]
at = [[0.0, 0.0], [-0.1, 0.0]]
[contacts.stop]
type = "angle-stop"
joint = "pin"
upper = 0.5
radius = {}
direction = 0.5
stiffness = 1e12
surface = "steel"
[surfaces.steel]
restitution = 0.6
[run]
duration = 0.06
start = "given"
)",
                                  radius);
    for (const auto& way : ways) {
      auto scene = scene_by(text, way);
      if (way.step > 0) scene.nonsmooth.step = 1e-5;
      Simulation simulation(scene, test::name_of(way.family));
      const auto& elements = simulation.layout().forces;
      Forces sum;
      sum.elements.resize(elements.size());
      sum.acceleration.resize(3);
      test::Listener listener;
      listener.want.forces = true;
      listener.on_step = [&](const Step& step) {
        sum.add(1, step.before());
        step.add_impulse(step.t0, step.t1, sum);
        sum.add(1, step.within());
      };
      const auto run = simulation.run({.observers = {&listener}});
      const auto touch = test::touch(run, 0);
      ElementForce pin;
      for (std::size_t k = 0; k < elements.size(); ++k)
        if (elements[k].name == "pin") pin = sum.elements[k];
      const std::string name = fmt::format("rod on a pin against a stop at {:.3g} m, {}", radius, way.name);
      const double bound = way.family == Family::penalty ? 1e-6 : way.step > 0 ? 1e-6 : 1e-9;
      f.relative(name + ": speed after it", "rad/s", run.final_state.v[2], -er * w, bound, "−e ω",
                 way.family == Family::penalty ? "\"exact\" delivers e; drift"
                 : way.step > 0                ? "rates at a step's end: (ω h)² and room"
                                               : "tolerance");
      f.within("the same: time of it", "s", touch.t, limit / w, way.step > 0 ? 1e-5 : 1e-8, "constant speed",
               way.step > 0 ? "a step" : "tolerance");
      // Momentum of the rod less what the stop did; the stop's impulse acts along −perp c.
      const double P = JO * (1 + er) * w / radius, end = limit - er * (w * T - limit);
      const double px = l * (er * w * std::sin(end)), py = l * (-er * w * std::cos(end) - w);
      const double bx = px - P * std::sin(limit), by = py + P * std::cos(limit);
      const double scale = l * w * (1 + er);
      f.at_most("the same: impulse of the pin, error over m l Δω", "",
                std::hypot(pin.fx - bx, pin.fy - by) / scale,
                way.family == Family::penalty ? 2e-3
                : way.step > 0                ? 2e-3
                                              : 1e-8,
                "momentum of the rod by hand",
                way.family == Family::nonsmooth && way.step == 0
                    ? "tolerance"
                    : "a step's turn, or a contact's, 1e-5 s × 10 rad/s, times P over the scale, 10");
    }
  }
}

/// A block against a damped spring that cannot pull, and a lever likewise: m ÿ + c ẏ + k y = 0 until the force is zero.
void bumps(Findings& f) {
  const double k = 2e4, m = 2.0, zeta = 0.3, w0 = std::sqrt(k / m), s = std::sqrt(1 - zeta * zeta), v = 1.5;
  const double lasts = std::atan2(2 * zeta * s, 2 * zeta * zeta - 1) / (s * w0),
               rebound = v * std::exp(-zeta * w0 * lasts);
  const std::string text = fmt::format(R"([bodies.block]
mass = 2.0
inertia = 2.0
velocity = [1.5, 0.0]
angular_velocity = 1.5
[loads.buffer]
type = "bump-stop"
between = ["ground", "block"]
upper = 0.02
lower = -0.3
stiffness = {0}
damping = {1}
[loads.catch]
type = "torsional-bump-stop"
between = ["ground", "block"]
upper = 0.02
stiffness = {0}
damping = {1}
[run]
duration = 0.1
start = "given"
)",
                                       k, 2 * zeta * w0 * m);
  for (const auto& way : ways) {
    const auto run = finished(scene_by(text, way), way);
    const auto& end = run.final_state;
    const bool stepped = way.step > 0, chosen = way.scheme == Scheme::automatic;
    const double bound = stepped ? 1e-4 : chosen ? 1e-4 : 1e-7;
    const char* why = stepped ? "the force begins within a step: ζ ω₀ h, 3e-5, and room"
                      : chosen
                          ? "steps chosen at 1e-6, of which a jump takes some tens"
                          : "tolerance 1e-10 in a step, of which the jump of the force takes some hundred";
    const std::string name = fmt::format("bump stop, ζ = 0.3, {}: ", way.name);
    f.relative(name + "speed after it", "m/s", end.v[0], -rebound, bound,
               "v exp(−ζ ω₀ t), t where the force is zero", why);
    f.relative("a torsional one, likewise", "rad/s", end.v[2], -rebound, bound, "the same", why);
    f.within("the same: place after it", "m", end.q[0],
             0.02 - v * std::exp(-zeta * w0 * lasts) * std::sin(s * w0 * lasts) / (s * w0) * -1 -
                 rebound * (0.1 - 0.02 / v - lasts),
             0.1 * bound, "y(t) = (v/ω_d) e^{−ζω₀t} sin ω_d t, then free", why);
    f.at_most("the same: energy not accounted for, over the start's", "",
              std::abs(run.ledger.closure()) / run.ledger.initial, bound, "½ k y² and what the damper takes",
              why);
  }
}

}  // namespace

Findings gears() {
  Findings f;
  rattle(f);
  reactions(f);
  planet(f);
  distance(f);
  racks(f);
  slots(f);
  stops(f);
  bumps(f);
  return f;
}

}  // namespace freeplay::verification
