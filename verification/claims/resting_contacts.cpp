// Rest on contacts, and that a run which begins at rest stays there.
#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <stdexcept>
#include <utility>

#include "facade/simulation.hpp"
#include "mechanism/mechanism.hpp"
#include "verification/claims/equilibrium_claims.hpp"
#include "verification/support/support.hpp"
#include "verification/support/ways.hpp"

namespace freeplay::verification::equilibrium_claims {

namespace {

Scene lamp_scene(bool loose) {
  auto scene = read_scene(test::source_folder() / "cases/spring-balance/scene.toml");
  if (!loose) scene.mechanism = idealised(scene.mechanism);
  return scene;
}

using test::Way;
const Way ways[] = {test::penalty, test::fixed_steps(1e-4), test::event_driven, test::automatic};

}  // namespace

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

void stays(Findings& f) {
  const std::pair<const char*, Scene> scenes[] = {{"ideal slider-crank", sprung_scene(false)},
                                                  {"loose slider-crank", sprung_scene(true)},
                                                  {"loose desk lamp", lamp_scene(true)}};
  for (const auto& [what, facts] : scenes)
    for (const auto& way : ways) {
      auto scene = facts;
      way.choose(scene);
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
        if (way.fixed() && step.t0 == 0) return;
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

}  // namespace freeplay::verification::equilibrium_claims
