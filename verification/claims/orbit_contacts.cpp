// Periodic motions of penalty runs whose contacts are closed at the section.
#include "analysis/orbit.hpp"
#include "verification/claims/claim.hpp"
#include "verification/claims/orbit_scenes.hpp"
#include "verification/references/orbits.hpp"
#include "verification/support/runs.hpp"

namespace freeplay::verification {
namespace {

constexpr double carried_radius = 0.05;  // m, of the body in scenes::loaded_table()

struct CompliantContact {
  std::string name;
  reference::CompliantTable table;

  /// The motion that begins beside the periodic one by one part in a thousand of the static depth.
  Orbit found(long double amplitude) const {
    const reference::LoadedTable rigid{table.frequency, table.gravity, table.mass};
    const auto number = [](long double x) { return fmt::format("{:.17g}", static_cast<double>(x)); };
    const auto height = amplitude * std::sin(table.start), w = table.frequency;
    const auto depth = table.mass * table.gravity / table.stiffness;
    const auto speed = amplitude * w * std::cos(table.start);
    const auto body = [&](const char* which, const char* what, long double value) {
      return fmt::format("bodies.{}.{}=[0, {}]", which, what, number(value));
    };
    std::vector<std::string> keys{
        "run.start=given",
        body("table", "position", height),
        body("table", "velocity", speed),
        body("lower", "position", height + carried_radius + table.distance(amplitude) - 1e-3L * depth),
        body("lower", "velocity", speed + table.speed(amplitude)),
        "contacts.pair.stiffness=" + number(table.stiffness),
        "surfaces.hard.restitution=1",
        "penalty.tolerance=1e-12"};
    if (table.damping > 0)
      keys.insert(keys.end(),
                  {"penalty.contact=kelvin-voigt", "penalty.kelvin_stiffness=" + number(table.stiffness),
                   "penalty.kelvin_damping=" + number(table.damping)});
    return orbit(parse_scene(scenes::loaded_table(rigid, amplitude), "table", keys),
                 {.formulation = "penalty", .settle = 0});
  }
  double force(const Orbit& o) const {
    return o.failure.empty() && o.lasting.size() == 1 ? o.lasting[0].least_force : NAN;
  }
};

}  // namespace

void orbits_of_closed_contacts(Findings& f) {
  const char* const source = "linear oscillator on a shaken support in closed form";
  constexpr long double w = 100, g = 9.81L, m = 0.3L;
  const auto at = [&](long double square, long double share) {
    const long double K = m * w * w / square;
    return reference::CompliantTable{w, g, m, K, 2 * share * std::sqrt(K * m)};
  };
  const std::array<CompliantContact, 5> cases{{{"(ω/ω₀)² = 0.5", at(0.5L, 0)},
                                               {"(ω/ω₀)² = 0.1", at(0.1L, 0)},
                                               {"(ω/ω₀)² = 0.013", at(0.013L, 0)},
                                               {"(ω/ω₀)² = 2.5", at(2.5L, 0)},
                                               {"(ω/ω₀)² = 0.1, damping ratio 0.1", at(0.1L, 0.1L)}}};
  for (const auto& c : cases) {
    const auto name = [&](const char* what) {
      return claim_name("body on a shaken table, compliant contact with " + c.name, what, "penalty");
    };
    const long double expected = c.table.liftoff(), low = 0.8L * expected, high = 0.9L * expected;
    const auto first = c.found(low), second = c.found(high);
    const double weight = static_cast<double>(m * g);
    f.within(name("least contact force over the weight at 0.8 of the amplitude of lift-off"), "",
             c.force(first) / weight, static_cast<double>(c.table.least_force(low)) / weight, 2e-6, source,
             "tolerance 1e-12 of 0.05 m per step, some hundred steps, over a depth of 13 µm");
    const auto multiplier = c.table.multiplier();
    const bool both = first.failure.empty() && first.multipliers.size() == 2;
    f.within(name("half the sum of the multipliers"), "",
             both ? 0.5 * (first.multipliers[0] + first.multipliers[1]).real() : NAN,
             static_cast<double>(multiplier.real()), 1e-7, source,
             "derivatives settle to 1e-8; ten oscillations in a period");
    f.within(name("product of the multipliers"), "",
             both ? (first.multipliers[0] * first.multipliers[1]).real() : NAN,
             static_cast<double>(std::norm(multiplier)), 1e-7, source,
             "derivatives settle to 1e-8; ten oscillations in a period");
    // The force is linear in the amplitude.
    const double slope = (c.force(second) - c.force(first)) / static_cast<double>(high - low);
    f.relative(name("amplitude of lift-off"), "m", static_cast<double>(low) - c.force(first) / slope,
               static_cast<double>(expected), 2e-5, source,
               "the extrapolation from 0.8 and 0.9 of it enlarges an error of 2e-6 of the weight tenfold");
    // Beyond it, the contact opens, or its force stays at zero for a while.
    const auto before = c.found(0.999L * expected), beyond = c.found(1.001L * expected);
    f.within(name("least contact force over the weight at 0.999 of the amplitude of lift-off"), "",
             c.force(before) / weight, 1e-3, 2e-6, source,
             "tolerance 1e-12 of 0.05 m per step, some hundred steps, over a depth of 13 µm");
    f.within(name("least contact force over the weight at 1.001 of the amplitude of lift-off"), "",
             !beyond.failure.empty()  ? NAN
             : beyond.lasting.empty() ? 0
                                      : c.force(beyond) / weight,
             0, 0, source, "contacts do not pull");
  }
}

}  // namespace freeplay::verification
