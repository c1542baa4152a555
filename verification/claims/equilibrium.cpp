// Equilibria and small oscillations of pendulums, spring-supported bodies and a slider-crank.
#include "verification/claims/equilibrium_claims.hpp"

#include <fmt/format.h>

#include "dynamics/assembly/assembly.hpp"
#include "formulations/make.hpp"
#include "verification/references/pendulum.hpp"
#include "verification/support/scene_text.hpp"
#include "verification/support/support.hpp"

namespace freeplay::verification::equilibrium_claims {

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
Rest rest(const char* scene, Family family) { return rest(read_scene(test::scene_file(scene)), family); }

namespace {

Rest bar_near(double angle) {
  return rest(
      read_scene(test::scene_file("hanging_bar"),
                 {fmt::format("bodies.bar.angle={}", angle),
                  fmt::format("bodies.bar.position=[{}, {}]", 0.3 * std::cos(angle), 0.3 * std::sin(angle))}),
      Family::nonsmooth);
}

}  // namespace

void pendulums(Findings& f) {
  const reference::Pendulum p{2, 0.03, 0.3, 9.81, 0};
  const auto hangs = bar_near(0.4);
  f.within("pendulum: equilibrium angle, initial guess 0.4 rad", "rad", hangs.at.state.q[2], -pi / 2, 1e-12,
           "−π/2", "rounding");
  f.relative("pendulum: angular frequency of small oscillations", "rad/s", hangs.rate(0), p.small_rate(),
             1e-10, "√(m g a/(J + m a²))", exact);
  const auto upright = bar_near(pi / 2);
  f.within("upright pendulum: number of unstable motions", "", upright.at.runaway, 1, 0, "1", "exact");
  f.relative("upright pendulum: growth rate", "1/s", upright.modes.at(0).s.real(), p.small_rate(), 1e-10,
             "√(m g a/(J + m a²))", exact);

  const reference::HangingPair two{0.471, 0.0035, 0.15, 0.3, 0.39, 0.002, 0.125, 9.81};
  const auto pair = rest("hanging_pair");
  for (const std::size_t i : {0, 1})
    f.relative(claim_name("double pendulum", fmt::format("angular frequency of mode {}", i + 1)), "rad/s",
               pair.rate(i), two.rates()[i], 1e-10, "references/small_motions: quadratic equation", exact);
}

void springs(Findings& f) {
  // Two stretched springs in line: along them k₁ + k₂, across them the tension T (1/l₁ + 1/l₂).
  const auto held = rest("mass_between_springs");
  // 200 (1 + x − 0.8) = 300 (1 − x − 0.6)
  const double x = 80.0 / 500, tension = 200 * (0.2 + x);
  f.within("mass between two stretched springs: equilibrium position", "m", held.at.state.q[0], x, 1e-13,
           "equal spring forces", "rounding");
  f.relative("mass between two stretched springs: angular frequency across the springs", "rad/s",
             held.rate(0), sqrt(tension * (1 / (1 + x) + 1 / (1 - x)) / 3), 1e-10, "√(T (1/l₁ + 1/l₂)/m)",
             exact);
  f.relative("mass between two stretched springs: angular frequency along the springs", "rad/s", held.rate(1),
             sqrt(500.0 / 3), 1e-10, "√((k₁ + k₂)/m)", exact);
  // A block on a spring with damper under a constant force.
  const auto block = rest("loaded_block");
  f.within("block on spring and damper under a constant force: equilibrium position", "m",
           block.at.state.q[1], 0.3 - (4 * 9.81 + 20) / 900, 1e-13, "l₀ − F/k", "rounding");
  const auto s = block.modes.at(0).s;
  f.relative("block on spring and damper under a constant force: damped angular frequency", "rad/s", s.imag(),
             sqrt(900.0 / 4 - 1.5 * 1.5), 1e-10, "√(k/m − (d/2m)²)", exact);
  f.relative("block on spring and damper under a constant force: damping ratio", "",
             block.modes.at(0).damping(), 12 / (2 * sqrt(900.0 * 4)), 1e-10, "d/(2√(k m))", exact);
  // A torque u = u₀ + c φ with a lag τ: (J s² + d s + k)(τ s + 1) = c.
  const auto lagged = rest("lagging_rotor");
  const double phi = 3 / (8 - 1.5);
  f.within("rotor on a spring with a lagging torque 3 + 1.5 φ: equilibrium angle", "rad",
           lagged.at.state.q[2], phi, 1e-13, "k φ = u(φ)", "rounding");
  f.within("rotor on a spring with a lagging torque 3 + 1.5 φ: torque at equilibrium", "N m",
           lagged.at.state.z.at(0), 8 * phi, 1e-12, "k φ", "rounding");
  double worst = 0;
  for (const auto& m : lagged.modes)
    worst = greatest(worst, std::abs((0.5 * m.s * m.s + 0.4 * m.s + 8.0) * (0.05 * m.s + 1.0) - 1.5));
  f.at_most(
      "rotor on a spring with a lagging torque 3 + 1.5 φ: characteristic polynomial at the computed "
      "eigenvalues",
      "N m", worst, 1e-10, "(J s² + d s + k)(τ s + 1) − c = 0", "rounding of terms of 100");
}

reference::SprungSliderCrank sprung() {
  return {0.1L, 0.3L, 0.5L, 0.0008L, 0.9L, 0.007L, 1.1L, -3, -9.81L, 6, 1.2L};
}
Scene sprung_scene(bool clearance_joint) {
  auto scene = read_scene(test::scene_file("sprung_slider_crank"));
  if (!clearance_joint) scene.mechanism = idealised(scene.mechanism);
  return scene;
}

void slider_crank(Findings& f) {
  const auto s = sprung();
  const long double theta = s.rest(0.3L, 1.5L);
  const auto at = s.at(theta);
  const auto found = rest(sprung_scene(false), Family::nonsmooth);
  f.within("ideal slider-crank on a torsional spring under inclined weight: equilibrium crank angle", "rad",
           found.at.state.q[2], static_cast<double>(theta), 1e-12, "references/small_motions: U′ = 0",
           "rounding");
  f.relative("ideal slider-crank on a torsional spring under inclined weight: angular frequency", "rad/s",
             found.rate(0), static_cast<double>(std::sqrt(at.curvature / at.inertia)), 1e-10,
             "references/small_motions: U″/I", exact);
}

}  // namespace freeplay::verification::equilibrium_claims

namespace freeplay::verification {

Parts equilibrium() {
  using namespace equilibrium_claims;
  return {pendulums, springs, slider_crank, lamp, contacts, stays};
}

}  // namespace freeplay::verification
