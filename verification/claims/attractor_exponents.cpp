// Largest Lyapunov exponents of attractors of a bifurcation diagram and of a basin against closed forms.
#include <complex>
#include <filesystem>

#include "io/files/output_file.hpp"
#include "study/attractors/attractor_exponents.hpp"
#include "study/attractors/attractor_runs.hpp"
#include "study/attractors/attractor_table.hpp"
#include "study/settings/study.hpp"
#include "verification/claims/claim.hpp"
#include "verification/claims/orbit_scenes.hpp"
#include "verification/references/orbits.hpp"
#include "verification/support/runs.hpp"

namespace freeplay::verification {
namespace {

/// The runs of a study with their exponents. `text`: its tables, for a scene beside it.
SettledRuns runs_with_exponents(const std::string& scene, const std::string& text) {
  const test::TemporaryFolder folder;
  write_file(folder.path() / "scene.toml", scene);
  write_file(folder.path() / "study.toml", "scene = \"scene.toml\"\n" + text);
  const auto study = read_study(folder.path() / "study.toml");
  const bool basin = study.basin.has_value();
  const AttractorPlan& plan = basin ? static_cast<const AttractorPlan&>(*study.basin) : *study.bifurcation;
  const auto chains = basin ? basin_chains(study) : bifurcation_chains(study);
  AttractorStore store(folder.path() / "runs.db", {});
  auto runs = settle(study, plan, basin ? "basin" : "bifurcation", chains, store, 1, {}, {});
  const auto classified = basin ? attractors_of_all(runs) : attractors_at_each_value(runs);
  add_exponents(study, plan, chains, classified, store, 1, {}, {}, runs);
  return runs;
}

/// Exponent times the period; NaN if the run has none or another number of periods.
double per_period(const SettledRun& run, long double period) {
  return run.exponent && run.attractor.period == 1 ? run.exponent->value * static_cast<double>(period) : NAN;
}

/// A rotor with the equation of the oscillator: m is its inertia, and the coordinate its angle, rad.
std::string impact_rotor(const reference::ImpactOscillator& o, const reference::ImpactOscillator::Motion& m,
                         long double after) {
  const auto number = [](long double x) { return static_cast<double>(x); };
  return test::body("rotor", 1, number(o.mass),
                    fmt::format("angle = {:.17g}\nangular_velocity = {:.17g}\n", number(o.position(m, after)),
                                number(o.velocity(m, after)))) +
         test::pin("axle", "ground", "rotor") +
         test::torsion("spring", "ground", "rotor", number(o.stiffness),
                       fmt::format("damping = {:.17g}\n", number(o.damping))) +
         test::stop("stop", "angle-stop", "axle",
                    fmt::format("radius = 0.1\nupper = {:.17g}\n", number(o.stop)), "hard") +
         test::surface("hard", number(o.restitution)) +
         test::harmonic(
             "push", number(o.force), number(2 * std::acos(-1.0L) / o.frequency),
             fmt::format("phase = {:.17g}\n", number(m.psi + std::acos(-1.0L) / 2 + o.frequency * after))) +
         test::drive("shaker", "axle", "torque_curve = \"push\"\nagainst = \"time\"\n") +
         test::run_for(1, "start = \"given\"\n") + scenes::event_driven;
}

}  // namespace

void attractor_exponents(Findings& f) {
  constexpr double eight_digits = 1e-8;
  const char* const required = "required: eight digits of the multiplier of one cycle";
  const std::string source = "logarithm of the greatest multiplier in closed form";
  const long double omega = 20 * reference::ShakenBall::pi();
  for (const auto& [subject, share] :
       {std::pair<const char*, long double>{
            "ball on a shaken table, bifurcation diagram 1 % below period doubling", 0.99L},
        {"ball on a shaken table, bifurcation diagram where the multipliers are a pair", 0.8L}}) {
    reference::ShakenBall ball{0, omega, 9.81L, 0.5L};
    ball.amplitude = share * ball.flip();
    const auto runs = runs_with_exponents(
        scenes::shaken_ball(ball, 0),
        fmt::format("[axes.amplitude]\nkey = \"curves.shake.amplitude\"\nvalues = [{:.17g}]\n[bifurcation]\n"
                    "direction = \"up\"\nsection = \"each touch\"\ncolumns = [\"approach\"]\ndiscard = 10\n"
                    "keep = 6\nexponents = true\n",
                    static_cast<double>(ball.amplitude)));
    const auto pair = reference::multipliers(ball.trace(), ball.determinant());
    f.within(claim_name(subject, "largest exponent per period", "event-driven"), "",
             per_period(runs.chains.at(0).at(0), ball.period()),
             static_cast<double>(std::log(std::abs(pair[0]))), eight_digits, source, required);
  }

  // Of the difference of 1e-4 rad of the second start, the greatest multiplier leaves the share 0.57^40.
  const reference::ImpactOscillator o{0.5L, 1, 200, 3, 30, 0.02L, 0.7L};
  const auto motion = o.motion();
  const long double after = o.period() / 2;
  const auto at = static_cast<double>(o.position(motion, after));
  const auto period = static_cast<double>(o.period());
  const auto runs = runs_with_exponents(
      impact_rotor(o, motion, after),
      fmt::format("[axes.angle]\nkey = \"bodies.rotor.angle\"\nvalues = [{:.17g}, {:.17g}]\n[axes.speed]\n"
                  "key = \"bodies.rotor.angular_velocity\"\nvalues = [{:.17g}]\n[basin]\n"
                  "section = \"every {:.17g} s\"\nperiod = {:.17g}\ndiscard = 40\nkeep = 6\n"
                  "columns = [\"axle.angle\"]\nexponents = true\n",
                  at, at - 1e-4, static_cast<double>(o.velocity(motion, after)), period, period));
  const auto pair = reference::multipliers(o.trace(), o.determinant());
  const char* const subject = "rotor with a spring and a stop, basin";
  for (std::size_t i = 0; i < 2; ++i)
    f.within(
        claim_name(subject, fmt::format("largest exponent per period from start {}", i + 1), "event-driven"),
        "", per_period(runs.chains.at(i).at(0), o.period()), static_cast<double>(std::log(std::abs(pair[0]))),
        eight_digits, source, required);
}

}  // namespace freeplay::verification
