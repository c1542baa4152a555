// Periodic motions of penalty runs whose contacts are closed at the section.
#include <complex>

#include "analysis/orbit.hpp"
#include "formulations/contact/contact_law.hpp"
#include "verification/claims/orbit_scenes.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;
namespace scenes = freeplay::verification::scenes;

namespace {

const reference::LoadedTable carried_table{60, 9.81L, 0.3L};
constexpr double carried_stiffness = 3e3;  // N/m

/// A body that stays on its shaken table, with a contact force that has hysteresis. `share`: of the
/// amplitude at which it would separate from a rigid carried_table.
Scene carried(long double share) {
  return parse_scene(scenes::loaded_table(carried_table, share * carried_table.liftoff()), "table",
                     {fmt::format("contacts.pair.stiffness={}", carried_stiffness),
                      "surfaces.hard.restitution=0.9", "penalty.tolerance=1e-12"});
}

}  // namespace

TEST_CASE("multipliers of a penalty motion do not depend on the phase of its section", "[orbit]") {
  const reference::ShakenBall ball{0.0032L, 20 * reference::ShakenBall::pi(), 9.81L, 0.5L};
  const auto scene = parse_scene(scenes::shaken_ball(ball, 1e-4L), "ball",
                                 {"surfaces.hard.young=2e8", "surfaces.hard.poisson=0.3",
                                  "penalty.contact=exact", "penalty.tolerance=1e-12"});
  const auto open = orbit(scene, {.formulation = "penalty", .settle = 20});
  REQUIRE(open.failure.empty());
  REQUIRE(open.impacts.size() == 1);
  REQUIRE(open.multipliers.size() == 2);
  CHECK(open.lasting.empty());
  const double onset = open.impacts[0].t / open.period;
  // The contact lasts for about 0.02 periods; after its compression it expands.
  for (const double after : {0.003, 0.012}) {
    CAPTURE(after);
    const auto closed = orbit(scene, {.formulation = "penalty", .settle = onset + after});
    REQUIRE(closed.failure.empty());
    CHECK(closed.lasting.empty());
    CHECK(closed.impacts.size() == 1);
    // v₀ and the mass that the contact retains follow from the state at its onset.
    REQUIRE(closed.multipliers.size() == 4);
    // Errors of 1e-12 a step over the relative depth of the contact, 1e-3 of the amplitude.
    for (std::size_t i = 0; i < 2; ++i)
      CHECK(std::abs(closed.multipliers[i].real() - open.multipliers[i].real()) < 1e-6);
    for (std::size_t i = 2; i < 4; ++i) CHECK(std::abs(closed.multipliers[i]) < 1e-6);
  }
}

TEST_CASE("multipliers of a lasting contact are the decay of its transients", "[orbit]") {
  const auto scene = carried(0.5L);
  const auto found = orbit(scene, {.formulation = "penalty", .settle = 60});
  INFO(found.failure);
  REQUIRE(found.failure.empty());
  REQUIRE(found.lasting.size() == 1);
  CHECK(found.lasting[0].least_force > 0);
  CHECK_FALSE(found.lasting[0].v0);  // each compression is a new impact
  CHECK(found.impacts.empty());
  REQUIRE(found.multipliers.size() == 4);
  for (std::size_t i = 2; i < 4; ++i) CHECK(std::abs(found.multipliers[i]) < 1e-6);
  // Changes over a period, in the limit d_k+2 = trace d_k+1 - determinant d_k.
  Simulation simulation(scene, "penalty");
  const auto change = [&](double& q, double& v) {
    const auto before = simulation.state();
    simulation.run({.until = simulation.t() + found.period});
    const auto after = simulation.state();
    q = after.q[4] - before.q[4];
    v = after.v[4] - before.v[4];
  };
  simulation.run({.until = 18 * found.period});
  double q[3], v[3];
  for (int k = 0; k < 3; ++k) change(q[k], v[k]);
  const double det = q[1] * v[0] - q[0] * v[1];
  const double trace = (q[2] * v[0] - q[0] * v[2]) / det, determinant = (q[2] * v[1] - q[1] * v[2]) / det;
  // Changes of some 1e-6 m/s are 1e-5 of the rates of the motion.
  CHECK(std::abs((found.multipliers[0] + found.multipliers[1]).real() - trace) < 1e-4);
  CHECK(std::abs((found.multipliers[0] * found.multipliers[1]).real() - determinant) < 1e-4);
}

TEST_CASE("a contact that is hardly shaken keeps its approach speed", "[orbit]") {
  const auto found = orbit(carried(1e-3L), {.formulation = "penalty", .settle = 60});
  INFO(found.failure);
  REQUIRE(found.failure.empty());
  REQUIRE(found.lasting.size() == 1);
  REQUIRE(found.lasting[0].v0);
  REQUIRE(found.multipliers.size() == 2);
  // F = K d (1 + chi d'/v0) about K d = m g: a damper m g chi/v0.
  const double m = static_cast<double>(carried_table.mass), g = static_cast<double>(carried_table.gravity);
  const double decay = g * damping_factor(ContactLaw::exact, 0.9) / (2 * *found.lasting[0].v0);
  const std::complex<double> s(-decay, std::sqrt(carried_stiffness / m - decay * decay));
  const auto expected = std::exp(s * found.period);
  // Terms of second order in the share of the amplitude, 1e-6, over some periods of the oscillation.
  CHECK(std::abs(found.multipliers[0].real() - expected.real()) < 1e-4);
  CHECK(std::abs(std::abs(found.multipliers[0].imag()) - std::abs(expected.imag())) < 1e-4);
}
