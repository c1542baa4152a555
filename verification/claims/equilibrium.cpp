// Where mechanisms rest, how they swing about it, and that a run which begins there stays.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "facade/simulation.hpp"
#include "formulations/make.hpp"
#include "model/assembly.hpp"
#include "model/mechanism.hpp"
#include "model/modes.hpp"
#include "model/scene.hpp"
#include "model/system.hpp"
#include "verification/claims/claim.hpp"
#include "verification/references/pendulum.hpp"
#include "verification/references/small_motions.hpp"
#include "verification/support.hpp"

namespace freeplay::verification {
namespace {

using std::sqrt;
constexpr double pi = std::numbers::pi;
constexpr const char* exact =
    "derivatives are exact: rounding of the place and of the values, 1e-13, room of a thousand";
constexpr const char* steel =
    "[surfaces]\nsteel = {young = 207e9, poisson = 0.3, restitution = 0.5}\n[run]\nduration = 1\n"
    "start = \"equilibrium\"\n";
/// Hertz's K of steel on steel at a radius of curvature (m), from the formula.
double hertz(double radius) { return 4.0 / 3 * 207e9 / (2 * (1 - 0.3 * 0.3)) * sqrt(radius); }

struct Rest {
  Equilibrium at;
  std::vector<Mode> modes;
  Forces forces;
  /// rad/s of the i-th that swings.
  double rate(std::size_t i) const {
    for (const auto& m : modes)
      if (m.kind == Mode::Kind::swing && i-- == 0) return std::abs(m.s);
    return NAN;
  }
};

Rest rest(const Scene& scene, Family family) {
  const System system(scene.mechanism);
  const auto elastic = compliances(family, scene, system);
  const auto from = assemble(scene.mechanism, RunOptions::Start::assembled);
  Rest r;
  r.at = find_equilibrium(scene.mechanism, system, from.q, elastic);
  r.modes = find_modes(system, r.at, elastic).modes;
  r.forces = static_forces(system, r.at);
  return r;
}
Rest rest(const std::string& text, Family family = Family::nonsmooth) {
  return rest(parse_scene(text, "claim"), family);
}

std::string pendulum_scene(double angle) {
  return fmt::format(
      "gravity = [0, -9.81]\n[bodies.bar]\nmass = 2\ninertia = 0.03\nposition = [{}, {}]\nangle = {}\n"
      "[joints.pivot]\ntype = \"revolute\"\nbetween = [\"ground\", \"bar\"]\nat = [[0, 0], [-0.3, 0]]\n"
      "[run]\nduration = 1\nstart = \"equilibrium\"\n",
      0.3 * std::cos(angle), 0.3 * std::sin(angle), angle);
}

void pendulums(Findings& f) {
  const reference::Pendulum p{2, 0.03, 0.3, 9.81, 0};
  const auto hangs = rest(pendulum_scene(0.4));
  f.within("pendulum from 0.4 rad above the level, rests at", "rad", hangs.at.state.q[2], -pi / 2, 1e-12,
           "straight down", "rounding");
  f.relative("its small swings", "rad/s", hangs.rate(0), p.small_rate(), 1e-10, "√(m g a/(J + m a²))", exact);
  const auto stands = rest(pendulum_scene(pi / 2));
  f.within("the same upright: motions that run away", "", stands.at.runaway, 1, 0, "it falls", "a count");
  f.relative("and the rate that it falls by", "1/s", stands.modes.at(0).s.real(), p.small_rate(), 1e-10,
             "the same root, with its sign", exact);

  const reference::HangingPair two{0.471, 0.0035, 0.15, 0.3, 0.39, 0.002, 0.125, 9.81};
  const auto pair = rest(
      "gravity = [0, -9.81]\n[bodies.upper]\nmass = 0.471\ninertia = 0.0035\nposition = [0.1, -0.1]\nangle = -0.8\n"
      "[bodies.lower]\nmass = 0.39\ninertia = 0.002\nposition = [0.3, -0.1]\nangle = 0.3\n"
      "[joints]\npivot = {type = \"revolute\", between = [\"ground\", \"upper\"], at = [[0, 0], [-0.15, 0]]}\n"
      "elbow = {type = \"revolute\", between = [\"upper\", \"lower\"], at = [[0.15, 0], [-0.125, 0]]}\n"
      "[run]\nduration = 1\n");
  for (const std::size_t i : {0, 1})
    f.relative(fmt::format("double pendulum, swing {}", i + 1), "rad/s", pair.rate(i), two.rates()[i], 1e-10,
               "references/small_motions: a quadratic", exact);
}

void springs(Findings& f) {
  // Two stretched springs in line: along them k₁ + k₂, across them the tension T (1/l₁ + 1/l₂).
  const auto held = rest(
      "[bodies.mass]\nmass = 3\ninertia = 1\nposition = [0.1, 0.05]\n[loads]\n"
      "a = {type = \"spring-damper\", between = [\"ground\", \"mass\"], at = [[-1, 0], [0, 0]], stiffness = 200, "
      "free_length = 0.8}\n"
      "b = {type = \"spring-damper\", between = [\"ground\", \"mass\"], at = [[1, 0], [0, 0]], stiffness = 300, "
      "free_length = 0.6}\n[run]\nduration = 1\n");
  // 200 (1 + x − 0.8) = 300 (1 − x − 0.6)
  const double x = 80.0 / 500, tension = 200 * (0.2 + x);
  f.within("mass between two stretched springs, rests at", "m", held.at.state.q[0], x, 1e-13,
           "equal tensions", "rounding");
  f.relative("its swing across them", "rad/s", held.rate(0), sqrt(tension * (1 / (1 + x) + 1 / (1 - x)) / 3),
             1e-10, "tension over length", exact);
  f.relative("its swing along them", "rad/s", held.rate(1), sqrt(500.0 / 3), 1e-10, "√((k₁ + k₂)/m)", exact);
  // A block on a preloaded spring, damped.
  const auto block = rest(
      "gravity = [0, -9.81]\n[bodies.block]\nmass = 4\ninertia = 1\nposition = [0, -0.1]\n"
      "[joints.guide]\ntype = \"translational\"\nbetween = [\"ground\", \"block\"]\naxis = [0, 1]\n[loads]\n"
      "spring = {type = \"spring-damper\", between = [\"ground\", \"block\"], at = [[0, 1], [0, 0]], stiffness = "
      "900, damping = 12, free_length = 0.7}\n"
      "pull = {type = \"force\", body = \"block\", force = [3, -20]}\n[run]\nduration = 1\n");
  f.within("block on a spring with a preload and a constant force, rests at", "m", block.at.state.q[1],
           0.3 - (4 * 9.81 + 20) / 900, 1e-13, "F/k", "rounding");
  const auto s = block.modes.at(0).s;
  f.relative("its damped swing", "rad/s", s.imag(), sqrt(900.0 / 4 - 1.5 * 1.5), 1e-10, "√(k/m − (d/2m)²)",
             exact);
  f.relative("its damping ratio", "", block.modes.at(0).damping(), 12 / (2 * sqrt(900.0 * 4)), 1e-10,
             "d/(2√(k m))", exact);
  // A torque that follows the angle with a lag: (J s² + d s + k)(τ s + 1) = c, u = u₀ + c φ.
  const auto lagged = rest(
      "[bodies.rotor]\nmass = 2\ninertia = 0.5\n[joints.pivot]\ntype = \"revolute\"\n"
      "between = [\"ground\", \"rotor\"]\n[loads.spring]\ntype = \"torsional-spring-damper\"\n"
      "between = [\"ground\", \"rotor\"]\nstiffness = 8\ndamping = 0.4\n[drives.motor]\njoint = \"pivot\"\n"
      "torque_table = [[-2, 0], [2, 6]]\nagainst = \"angle\"\nlag = 0.05\n[run]\nduration = 1\n");
  const double phi = 3 / (8 - 1.5);
  f.within("rotor on a spring with a lagging torque 3 + 1.5 φ, rests at", "rad", lagged.at.state.q[2], phi,
           1e-13, "k φ = u(φ)", "rounding");
  f.within("the torque's state there", "N m", lagged.at.state.z.at(0), 8 * phi, 1e-12, "k φ", "rounding");
  double worst = 0;
  for (const auto& m : lagged.modes)
    worst = greatest(worst, std::abs((0.5 * m.s * m.s + 0.4 * m.s + 8.0) * (0.05 * m.s + 1.0) - 1.5));
  f.at_most("its characteristic polynomial at the modes found", "N m", worst, 1e-10,
            "(J s² + d s + k)(τ s + 1) − c", "rounding of terms of 100");
}

reference::SprungSliderCrank sprung() {
  return {0.1L, 0.3L, 0.5L, 0.0008L, 0.9L, 0.007L, 1.1L, -3, -9.81L, 6, 1.2L};
}
Scene sprung_scene(bool loose) {
  return parse_scene(
      fmt::format(
          "gravity = [-3, -9.81]\n[bodies.crank]\nmass = 0.5\ninertia = 0.0008\nposition = [0.04, 0.03]\n"
          "angle = 0.6\n[bodies.rod]\nmass = 0.9\ninertia = 0.007\nposition = [0.22, 0.03]\nangle = -0.2\n"
          "[bodies.slider]\nmass = 1.1\ninertia = 0.001\nposition = [0.37, 0]\n[joints]\n"
          "main = {{type = \"revolute\", between = [\"ground\", \"crank\"], at = [[0, 0], [-0.05, 0]]}}\n"
          "big_end = {{type = \"revolute\", between = [\"crank\", \"rod\"], at = [[0.05, 0], [-0.15, 0]]}}\n"
          "gudgeon = {{type = \"revolute\", between = [\"rod\", \"slider\"], at = [[0.15, 0], [0, 0]]{}}}\n"
          "guide = {{type = \"translational\", between = [\"ground\", \"slider\"], axis = [1, 0]}}\n[loads]\n"
          "spring = {{type = \"torsional-spring-damper\", between = [\"ground\", \"crank\"], stiffness = 6, "
          "free_angle = 1.2}}\n{}",
          loose ? ", clearance = 0.25e-3, bearing_radius = 0.011, surface = \"steel\"" : "", steel),
      "slider-crank");
}

void slider_crank(Findings& f) {
  const auto s = sprung();
  const long double theta = s.rest(0.3L, 1.5L);
  const auto at = s.at(theta);
  const auto found = rest(sprung_scene(false), Family::nonsmooth);
  f.within("slider-crank on a torsional spring under slanting weight, rests at", "rad", found.at.state.q[2],
           static_cast<double>(theta), 1e-12, "references/small_motions: U′ = 0", "rounding");
  f.relative("its swing", "rad/s", found.rate(0), static_cast<double>(std::sqrt(at.curvature / at.inertia)),
             1e-10, "references/small_motions: U″/I", exact);
}

Scene lamp_scene(bool loose) {
  auto scene = read_scene(test::source_folder() / "cases/spring-balance/scene.toml");
  if (!loose) scene.mechanism = idealised(scene.mechanism);
  return scene;
}

void lamp(Findings& f) {
  // U = w sin θ + ½ k (s − l₀)², s² = h² + a² − 2 h a sin θ (cases/spring-balance/README.md).
  const double w = 0.6 * 9.81, k = 300, h = 0.2, a = 0.12, free = 0.0426, inertia = 0.224, damping = 1;
  const double s = free / (1 - w / (k * h * a)), sine = (h * h + a * a - s * s) / (2 * h * a);
  const double across = h * a * sqrt(1 - sine * sine), stiffness = k * across * across * free / (s * s * s);
  const auto found = rest(lamp_scene(false), Family::nonsmooth);
  const std::string source = "energy of one angle, by hand";
  f.within("desk lamp balanced by a spring, ideal, its arm rests at", "rad", found.at.state.q[2],
           std::asin(sine), 1e-12, source, "rounding of a balance of 6 N m over 0.6 N m/rad");
  f.relative("its natural frequency", "Hz", found.modes.at(0).natural(), sqrt(stiffness / inertia) / (2 * pi),
             1e-10, source, exact);
  f.relative("its damping ratio", "", found.modes.at(0).damping(),
             damping * across * across / (s * s) / (2 * sqrt(stiffness * inertia)), 1e-10, source, exact);
}

void contacts(Findings& f) {
  for (const auto family : {Family::nonsmooth, Family::penalty}) {
    const bool yields = family == Family::penalty;
    const std::string way = std::string(", ") + name_of(family);
    const double m = 2, weight = m * 9.81, K = hertz(20e-3 * 19e-3 / 1e-3);
    const double depth = yields ? reference::hertz_depth(weight, K) : 0;
    const auto pin =
        rest(fmt::format("gravity = [0, -9.81]\n[bodies.disc]\nmass = 2\ninertia = 0.001\n"
                         "position = [0.4e-3, 0.3e-3]\n[joints.pin]\ntype = \"revolute\"\n"
                         "between = [\"ground\", \"disc\"]\nclearance = 1e-3\nbearing_radius = 20e-3\n"
                         "surface = \"steel\"\n{}",
                         steel),
             family);
    f.within("loose pin under its weight, depth below the centre" + way, "m", -pin.at.state.q[1],
             1e-3 + depth, 1e-15, yields ? "c + (m g/K)^⅔" : "c", "rounding of a millimetre's thousandfold");
    f.within("its normal force", "N", pin.at.normal.at(0), weight, 1e-9, "m g",
             "Hertz's force at a rounded depth");
    f.relative("its swing in the clearance", "rad/s", pin.rate(0), sqrt(9.81 / (1e-3 + depth)), 1e-9,
               yields ? "√(g/(c + δ)): a pendulum of that length" : "√(g/c): a pendulum of that length",
               "the place is rounded to 1e-12 of it");
    if (yields)
      f.relative("its bounce", "rad/s", pin.rate(1), reference::hertz_bounce(m, weight, K), 1e-9,
                 "√(1.5 K √δ/m)", "δ is rounded to 1e-13 of it, room of a thousand");
    const auto disc = rest(
        fmt::format(
            "gravity = [0, -10]\n[bodies.disc]\nmass = 2\ninertia = 0.01\nposition = [0.05, 0.3]\n"
            "[contacts]\nfloor = {{type = \"plane\", between = [\"ground\", \"disc\"], axis = [1, 0], radius = "
            "0.1, surface = \"steel\"}}\n[loads]\nspring = {{type = \"spring-damper\", between = [\"ground\", "
            "\"disc\"], at = [[0, -0.4], [0, 0]], stiffness = 500, free_length = 0.2}}\n{}",
            steel),
        family);
    // F = m g + k (0.5 − δ − l₀), δ = (F/K)^⅔: each pass gains six digits.
    double force = 170, sunk = 0;
    for (int i = 0; yields && i < 10; ++i) {
      sunk = reference::hertz_depth(force, hertz(0.1));
      force = 170 - 500 * sunk;
    }
    f.within("disc drawn to the ground by a spring, its force on the ground" + way, "N", disc.at.normal.at(0),
             force, 1e-9, yields ? "m g + k (l − δ − l₀), δ = (F/K)^⅔" : "m g + k (l − l₀)",
             "stiffness of the contact, 1e8 N/m, times rounding of a place, 1e-17 m");
    f.relative("its swing along the ground", "rad/s", disc.rate(0),
               sqrt(500 * (0.3 - sunk) / (0.5 - sunk) / 2), 1e-10, "tension over length", exact);
    // Three discs in a trough of 45°: the weights of two go down the walls.
    std::string walls;
    for (const char* disc : {"a", "b", "c"})
      walls += fmt::format(
          "l{0} = {{type = \"plane\", between = [\"ground\", \"{0}\"], axis = [1, -1], radius = 0.1, surface = "
          "\"steel\"}}\nr{0} = {{type = \"plane\", between = [\"ground\", \"{0}\"], axis = [1, 1], radius = 0.1, "
          "surface = \"steel\"}}\n",
          disc);
    const auto trough = rest(
        fmt::format(
            "gravity = [0, -10]\n[bodies]\na = {{mass = 2, inertia = 0.01, position = [-0.05, 0.3]}}\n"
            "b = {{mass = 1, inertia = 0.01, position = [0.2, 0.6]}}\n"
            "c = {{mass = 1, inertia = 0.01, position = [0.02, 1.6]}}\n[contacts]\n{}"
            "ab = {{type = \"discs\", between = [\"a\", \"b\"], radii = [0.1, 0.1], surface = \"steel\"}}\n"
            "bc = {{type = \"discs\", between = [\"b\", \"c\"], radii = [0.1, 0.1], surface = \"steel\"}}\n"
            "ac = {{type = \"discs\", between = [\"a\", \"c\"], radii = [0.1, 0.1], surface = \"steel\"}}\n{}",
            walls, steel),
        family);
    const double down = 10 / sqrt(2.0);
    const std::vector<double> expected{3 * down, 3 * down, 0, down, down, 0, down, 0, down};
    double off = 0;
    for (std::size_t k = 0; k < expected.size(); ++k)
      off = greatest(off, std::abs(trough.at.normal.at(k) - expected[k]));
    f.at_most("three discs that fall into a trough, greatest error of nine contact forces" + way, "N", off,
              yields ? 30 * 1e-5 : 1e-9, "balance by hand, walls of 45°",
              yields ? "Hertz's depths, 1e-6 m over radii of 0.1 m, turn the normals" : "rounding");
  }
}

struct Way {
  const char* name;
  Family family;
  std::optional<Scheme> scheme;
};
constexpr Way ways[] = {{"penalty", Family::penalty, {}},
                        {"Moreau–Jean", Family::nonsmooth, Scheme::moreau_jean},
                        {"event-driven", Family::nonsmooth, Scheme::event_driven},
                        {"automatic", Family::nonsmooth, Scheme::automatic}};

void stays(Findings& f) {
  const std::pair<const char*, Scene> scenes[] = {{"ideal slider-crank", sprung_scene(false)},
                                                  {"loose slider-crank", sprung_scene(true)},
                                                  {"loose desk lamp", lamp_scene(true)}};
  for (const auto& [what, facts] : scenes)
    for (const auto& way : ways) {
      auto scene = facts;
      if (way.scheme) scene.nonsmooth.scheme = way.scheme;
      if (way.scheme == Scheme::moreau_jean) scene.nonsmooth.step = 1e-4;
      const auto still = rest(scene, way.family);
      Simulation simulation(scene, test::name_of(way.family));
      const auto start = simulation.state();
      test::Listener listener;
      listener.want.forces = true;
      double force = 0;
      Forces now{std::vector<ElementForce>(still.forces.elements.size()),
                 std::vector<double>(start.q.size())};
      listener.on_step = [&](const Step& step) {
        // What a time step does in which a contact begins is an impact's.
        if (way.scheme == Scheme::moreau_jean && step.t0 == 0) return;
        step.forces(0.5 * (step.t0 + step.t1), now);
        for (std::size_t i = 0; i < now.elements.size(); ++i)
          force = greatest(force, std::hypot(now.elements[i].fx - still.forces.elements[i].fx,
                                             now.elements[i].fy - still.forces.elements[i].fy));
      };
      const auto result = simulation.run({.until = 1, .observers = {&listener}});
      if (result.ending.status != Ending::Status::finished) throw std::runtime_error(result.ending.reason);
      double drift = 0;
      for (std::size_t i = 0; i < start.q.size(); ++i)
        drift = greatest(drift, std::abs(result.final_state.q[i] - start.q[i]));
      const auto name = fmt::format("{} begun at rest, {}", what, way.name);
      f.at_most(
          name + ": how far any coordinate drifts in 1 s", "m, rad", drift, 1e-9, "it stays",
          "what remains of the forces, 1e-11 N, over a hundredth of a newton a metre; steps err by 1e-9 of that");
      f.at_most("its reactions, greatest difference from the static ones", "N", force,
                way.family == Family::penalty ? 2e-5 : 1e-6, "statics",
                way.family == Family::penalty
                    ? "a place known to the tolerance, 1e-9 of the clearance, times the contact's 7e7 N/m"
                    : "masses of 1 kg within 1e-7 m/s², what a tolerance of 1e-10 leaves of a step's rates");
      f.at_most("its energy balance", "J", std::abs(result.ledger.closure()), 1e-12, "the ledger",
                "rounding of a potential of 10 J, a hundredfold");
    }
}

}  // namespace

Findings equilibrium() {
  Findings f;
  pendulums(f);
  springs(f);
  slider_crank(f);
  lamp(f);
  contacts(f);
  stays(f);
  return f;
}

}  // namespace freeplay::verification
