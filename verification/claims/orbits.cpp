// Periodic motions and their multipliers against closed forms.
#include <complex>

#include "analysis/orbit.hpp"
#include "verification/claims/claim.hpp"
#include "verification/claims/orbit_scenes.hpp"
#include "verification/references/orbits.hpp"
#include "verification/support/runs.hpp"

namespace freeplay::verification {
namespace {

using Pair = std::array<std::complex<long double>, 2>;

constexpr double resolved = 1e-8;
const char* const resolved_reason = "required: eight digits; tolerance 1e-12 per step";

struct OrbitCase {
  Findings& f;
  std::string subject;
  Orbit found;

  std::string name(const std::string& quantity) const {
    return claim_name(subject, quantity, "event-driven");
  }
  void expect_motion(long double time, long double speed, const std::string& source) const {
    f.at_most(name("residual of the period"), "", found.failure.empty() ? found.residual : NAN, 1e-9,
              "definition", "a thousand times the tolerance of the integration");
    const bool once = found.impacts.size() == 1;
    f.within(name("time of the impact"), "s", once ? found.impacts[0].t - found.state.t : NAN,
             static_cast<double>(time), 1e-10, source, "tolerance 1e-12 per step over the rate of the map");
    f.relative(name("approach speed"), "m/s", once ? found.impacts[0].speed : NAN, static_cast<double>(speed),
               resolved, source, resolved_reason);
  }
  void expect_multipliers(const Pair& expected, const std::string& source, double bound = resolved,
                          const char* reason = resolved_reason) const {
    f.within(name("number of multipliers"), "", static_cast<double>(found.multipliers.size()), 2, 0, source,
             "one degree of freedom beside the drive");
    for (std::size_t i = 0; i < expected.size(); ++i) {
      const auto measured =
          found.multipliers.size() == expected.size() ? found.multipliers[i] : std::complex<double>(NAN, NAN);
      const auto which = i == 0 ? "first" : "second";
      f.within(name(fmt::format("real part of the {} multiplier", which)), "", measured.real(),
               static_cast<double>(expected[i].real()), bound, source, reason);
      f.within(name(fmt::format("imaginary part of the {} multiplier", which)), "", measured.imag(),
               static_cast<double>(expected[i].imag()), bound, source, reason);
    }
    const bool stable = std::abs(expected[0]) < 1;
    f.within(name("stability"), "", found.stable ? 1 : 0, stable ? 1 : 0, 0, source, "yes or no");
  }
};

OrbitCase ball_case(Findings& f, const std::string& subject, const reference::ShakenBall& b,
                    double settle = 0, long double beside = 1e-3L) {
  return {
      f, subject,
      orbit(parse_scene(scenes::shaken_ball(b, beside), "ball"), {.periods = b.number, .settle = settle})};
}

void balls(Findings& f) {
  const std::string source = "flight and impact in closed form";
  const long double omega = 20 * reference::ShakenBall::pi();
  const reference::ShakenBall stable{0.0032L, omega, 9.81L, 0.5L};
  const auto a = ball_case(f, "ball on a table that moves by 3.2 mm at 10 Hz", stable, 50);
  a.expect_motion(stable.impact_time(), stable.approach(), source);
  a.expect_multipliers(reference::multipliers(stable.trace(), stable.determinant()), source);

  const reference::ShakenBall unstable{0.01L, omega, 9.81L, 0.5L};
  const auto b = ball_case(f, "ball on a table that moves by 10 mm at 10 Hz", unstable);
  b.expect_motion(unstable.impact_time(), unstable.approach(), source);
  b.expect_multipliers(reference::multipliers(unstable.trace(), unstable.determinant()), source);

  const reference::ShakenBall twice{0.0075L, omega, 9.81L, 0.6L, 2};
  const auto c = ball_case(f, "ball that meets a table of 7.5 mm and 10 Hz in each second period", twice);
  c.expect_motion(twice.impact_time(), twice.approach(), source);
  c.expect_multipliers(reference::multipliers(twice.trace(), twice.determinant()), source);

  auto flip = stable;
  flip.amplitude = flip.flip();
  const auto d = ball_case(f, "ball on a table at the amplitude of period doubling", flip);
  d.expect_multipliers({-1, -0.25L}, "1 + trace + determinant = 0 in closed form");

  // At the fold itself the motion is a double root, whose error is the root of the map's error. One part
  // in a million above it the greatest multiplier differs from 1 by 0.0044, and the two motions are near
  // each other.
  for (const bool rising : {true, false}) {
    auto fold = stable;
    fold.rising = rising;
    fold.amplitude = fold.fold() * (1 + 1e-6L);
    const auto e =
        ball_case(f, fmt::format("ball just above the fold, {} branch", rising ? "stable" : "unstable"), fold,
                  0, 1e-5L);
    e.expect_multipliers(reference::multipliers(fold.trace(), fold.determinant()), source, 1e-7,
                         "the fold multiplies the error of the map by 500");
  }
}

OrbitCase oscillator_case(Findings& f, const std::string& subject, const reference::ImpactOscillator& o,
                          long double& impact) {
  const auto text = scenes::impact_oscillator(o, impact);
  return {f, subject, orbit(parse_scene(text, "oscillator"), {.periods = o.number, .settle = 0})};
}

void oscillators(Findings& f) {
  const std::string source = "linear oscillation with two matching conditions";
  const std::array<std::pair<const char*, reference::ImpactOscillator>, 4> cases{
      {{"oscillator with a stop at 5 mm, force of 22 rad/s", {0.5L, 1, 200, 3, 22, 0.005L, 0.7L}},
       {"oscillator with a stop at 20 mm, force of 30 rad/s, hard impact",
        {0.5L, 1, 200, 3, 30, 0.02L, 0.7L}},
       {"oscillator with a stop at 20 mm, force of 30 rad/s, soft impact",
        {0.5L, 1, 200, 3, 30, 0.02L, 0.7L, 1, false}},
       {"oscillator with a stop at 10 mm, impact in each second period of 45 rad/s",
        {0.5L, 1, 200, 3, 45, 0.01L, 0.7L, 2}}}};
  for (const auto& [subject, o] : cases) {
    long double impact = 0;
    const auto c = oscillator_case(f, subject, o, impact);
    c.expect_motion(impact, o.motion().v_minus, source);
    c.expect_multipliers(reference::multipliers(o.trace(), o.determinant()), source);
  }
}

/// The ball by contact forces: with an impact of the same restitution that lasts τ, the motion differs from
/// that of instantaneous impacts by O(τ), and τ ~ E^(−2/5) for Hertz contact.
void stiff_balls(Findings& f) {
  const std::string source = "motion with instantaneous impacts in closed form; duration of a Hertz impact";
  const reference::ShakenBall ball{0.0032L, 20 * reference::ShakenBall::pi(), 9.81L, 0.5L};
  const auto errors = [&](const char* young) {
    const auto found =
        orbit(parse_scene(scenes::shaken_ball(ball, 1e-4L), "ball",
                          {fmt::format("surfaces.hard.young={}", young), "surfaces.hard.poisson=0.3",
                           "penalty.contact=exact", "penalty.tolerance=1e-12"}),
              {.formulation = "penalty", .settle = 10});
    if (!found.failure.empty() || found.impacts.size() != 1 || found.multipliers.size() != 2)
      return std::array<double, 2>{NAN, NAN};
    const auto sum = found.multipliers[0] + found.multipliers[1];
    return std::array<double, 2>{
        std::abs(found.impacts[0].t - std::floor(found.impacts[0].t / found.period) * found.period -
                 static_cast<double>(ball.impact_time())),
        std::abs(sum.real() - static_cast<double>(ball.trace()))};
  };
  const auto soft = errors("2e9"), hard = errors("2e11");
  const char* const names[] = {"time of the impact", "sum of the multipliers"};
  for (std::size_t i = 0; i < 2; ++i)
    f.within(claim_name("ball on a table that moves by 3.2 mm at 10 Hz",
                        fmt::format("order in the stiffness of the error of the {}", names[i]), "penalty"),
             "", std::log(soft[i] / hard[i]) / std::log(100.0), 0.4, 0.06, source,
             "terms of second order in the duration, which is 1 % of the period at the lower stiffness");
}

}  // namespace

Parts orbits() { return {balls, stiff_balls, oscillators, orbits_of_schemes, orbits_of_closed_contacts}; }

}  // namespace freeplay::verification
