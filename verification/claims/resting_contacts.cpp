// Equilibria with closed contacts, and runs that start at equilibrium.
#include "mechanism/mechanism.hpp"
#include "verification/claims/equilibrium_claims.hpp"
#include "verification/support/runs.hpp"

namespace freeplay::verification::equilibrium_claims {

namespace {

Scene lamp_scene(bool clearance_joint) {
  auto scene = read_scene(test::source_folder() / "cases/spring-balance/scene.toml");
  if (!clearance_joint) scene.mechanism = idealised(scene.mechanism);
  return scene;
}

using test::Way;
const Way ways[] = {test::penalty, test::fixed_steps(1e-4, "Moreau–Jean, h = 1e-4 s"), test::event_driven,
                    test::automatic};

}  // namespace

void lamp(Findings& f) {
  // U = w sin θ + ½ k (s − l₀)², s² = h² + a² − 2 h a sin θ (cases/spring-balance/README.md).
  const double w = 0.6 * 9.81, k = 300, h = 0.2, a = 0.12, free = 0.0426, inertia = 0.224, damping = 1;
  const double s = free / (1 - w / (k * h * a)), sine = (h * h + a * a - s * s) / (2 * h * a);
  const double across = h * a * sqrt(1 - sine * sine), stiffness = k * across * across * free / (s * s * s);
  const auto found = rest(lamp_scene(false), Family::nonsmooth);
  const std::string source = "energy as a function of the arm's angle (cases/spring-balance)";
  f.within("ideal desk lamp balanced by a spring: equilibrium angle of the arm", "rad", found.at.state.q[2],
           std::asin(sine), 1e-12, source, "rounding of moments of 6 N m over a stiffness of 0.6 N m/rad");
  f.relative("ideal desk lamp balanced by a spring: natural frequency", "Hz", found.modes.at(0).natural(),
             sqrt(stiffness / inertia) / (2 * pi), 1e-10, source, exact);
  f.relative("ideal desk lamp balanced by a spring: damping ratio", "", found.modes.at(0).damping(),
             damping * across * across / (s * s) / (2 * sqrt(stiffness * inertia)), 1e-10, source, exact);
}

void contacts(Findings& f) {
  for (const auto family : {Family::nonsmooth, Family::penalty}) {
    const bool yields = family == Family::penalty;
    const auto pin_name = [&](const char* quantity) {
      return claim_name("pin with clearance under its weight", quantity, name_of(family));
    };
    const auto disc_name = [&](const char* quantity) {
      return claim_name("disc pulled to the ground by a spring", quantity, name_of(family));
    };
    const double m = 2, weight = m * 9.81, K = hertz(20e-3 * 19e-3 / 1e-3);
    const double depth = yields ? reference::hertz_depth(weight, K) : 0;
    const auto pin = rest("disc_on_loose_pin", family);
    f.within(pin_name("depth below the centre"), "m", -pin.at.state.q[1], 1e-3 + depth, 1e-15,
             yields ? "c + (m g/K)^⅔" : "c", "rounding of 1 mm, margin of 1e4");
    f.within(pin_name("normal force"), "N", pin.at.normal.at(0), weight, 1e-9, "m g",
             "Hertz's force at a depth with rounding");
    f.relative(pin_name("angular frequency in the clearance"), "rad/s", pin.rate(0),
               sqrt(9.81 / (1e-3 + depth)), 1e-9,
               yields ? "√(g/(c + δ)), pendulum of length c + δ" : "√(g/c), pendulum of length c",
               "position rounded to 1e-12 of the clearance");
    if (yields)
      f.relative(pin_name("angular frequency on the contact stiffness"), "rad/s", pin.rate(1),
                 reference::hertz_bounce(m, weight, K), 1e-9, "√(1.5 K √δ/m)",
                 "relative rounding of δ, 1e-13, margin of 1e4");
    const auto disc = rest("disc_on_spring", family);
    // F = m g + k (0.5 − δ − l₀), δ = (F/K)^⅔: each iteration gains six digits.
    double force = 170, sunk = 0;
    for (int i = 0; yields && i < 10; ++i) {
      sunk = reference::hertz_depth(force, hertz(0.1));
      force = 170 - 500 * sunk;
    }
    f.within(disc_name("normal force"), "N", disc.at.normal.at(0), force, 1e-9,
             yields ? "m g + k (l − δ − l₀), δ = (F/K)^⅔" : "m g + k (l − l₀)",
             "contact stiffness, 1e8 N/m, times rounding of the position, 1e-17 m");
    f.relative(disc_name("angular frequency along the ground"), "rad/s", disc.rate(0),
               sqrt(500 * (0.3 - sunk) / (0.5 - sunk) / 2), 1e-10, "√(T/(l m))", exact);
    // Three discs in a trough of 45°: the weights of two act along the walls.
    const auto trough = rest("discs_in_trough", family);
    const double down = 10 / sqrt(2.0);
    const std::vector<double> expected{3 * down, 3 * down, 0, down, down, 0, down, 0, down};
    double off = 0;
    for (std::size_t k = 0; k < expected.size(); ++k)
      off = greatest(off, std::abs(trough.at.normal.at(k) - expected[k]));
    f.at_most(claim_name("three discs in a trough", "nine contact forces, greatest error", name_of(family)),
              "N", off, yields ? 30 * 1e-5 : 1e-9, "static equilibrium, walls of 45°",
              yields ? "penetrations of 1e-6 m over radii of 0.1 m rotate the normals" : "rounding");
  }
}

void stays(Findings& f) {
  const std::pair<const char*, Scene> scenes[] = {
      {"ideal slider-crank started at equilibrium", sprung_scene(false)},
      {"slider-crank with clearance started at equilibrium", sprung_scene(true)},
      {"desk lamp with clearance started at equilibrium", lamp_scene(true)}};
  for (const auto& [subject, facts] : scenes)
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
        // A contact may close in the first time step, whose force then includes an impact.
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
      const auto name = [subject = subject, &way](const char* quantity) {
        return claim_name(subject, quantity, way.name);
      };
      f.at_most(name("greatest drift of a coordinate in 1 s"), "m, rad", drift, 1e-9, "0",
                "residual forces of 1e-11 N over a stiffness of 0.01 N/m; steps err by 1e-9 of that");
      f.at_most(name("reactions, greatest difference to the static ones"), "N", force,
                way.family == Family::penalty ? 2e-5 : 1e-6, "0",
                way.family == Family::penalty
                    ? "error of the position, 1e-9 of the clearance, times the contact stiffness of 7e7 N/m"
                    : "masses of 1 kg times 1e-7 m/s², the acceleration error of a step at tolerance 1e-10");
      f.at_most(name("error of the energy balance"), "J", std::abs(result.ledger.closure()), 1e-12, "0",
                "rounding of a potential energy of 10 J, margin of 100");
    }
}

}  // namespace freeplay::verification::equilibrium_claims
