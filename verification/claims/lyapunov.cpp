// Lyapunov exponents against closed forms, an independent billiard, and the sum rule.
#include "analysis/lyapunov.hpp"
#include "analysis/orbit.hpp"
#include "verification/claims/claim.hpp"
#include "verification/claims/orbit_scenes.hpp"
#include "verification/references/lyapunov.hpp"
#include "verification/references/orbits.hpp"
#include "verification/support/runs.hpp"

namespace freeplay::verification {
namespace {

struct Place {
  long double x, y;
};

/// A point of unit mass among fixed discs, as the paths of their scatterer need them. Half of the
/// radius is the ball's.
std::string scatterer(const std::vector<Place>& centres, long double radius, Place at, Place velocity,
                      long double duration) {
  auto text = fmt::format(
      "[bodies.ball]\nmass = 1\npoint = true\nposition = [{:.17g}, {:.17g}]\nvelocity = [{:.17g}, {:.17g}]\n",
      static_cast<double>(at.x), static_cast<double>(at.y), static_cast<double>(velocity.x),
      static_cast<double>(velocity.y));
  for (std::size_t i = 0; i < centres.size(); ++i)
    text += test::discs(fmt::format("disc{}", i + 1), "ground", "ball", static_cast<double>(radius / 2),
                        static_cast<double>(radius / 2), "hard",
                        fmt::format("at = [[{:.17g}, {:.17g}], [0, 0]]\n", static_cast<double>(centres[i].x),
                                    static_cast<double>(centres[i].y)));
  return text + "[surfaces.hard]\nrestitution = 1\n" + test::run_for(static_cast<double>(duration)) +
         scenes::event_driven;
}

double exponent_of(const Lyapunov& found, std::size_t i) {
  return found.failure.empty() && i < found.exponents.size() ? found.exponents[i].value : NAN;
}

void two_discs_claims(Findings& f) {
  const std::string source = "curvature of wave fronts: ln(R/a - 1 + sqrt((R/a)(R/a - 2)))";
  for (const double ratio : {2.5, 3.0, 6.0}) {
    const long double a = 1, r = ratio, flight = r - 2 * a;
    const auto growth = std::log(reference::two_discs(a, r));
    const auto text = scatterer({{0, 0}, {r, 0}}, a, {r / 2, 0}, {1, 0}, 60 * flight);
    const auto found =
        lyapunov(parse_scene(text, "discs"), {.batches = 10, .transient = static_cast<double>(20 * flight)});
    const auto subject = fmt::format("path between two discs, R/a = {:g}", ratio);
    const std::string sum_source = "conservation of volume and reversal of time";
    f.within(claim_name(subject, "greatest exponent per reflection", "event-driven"), "",
             exponent_of(found, 0) * static_cast<double>(flight), static_cast<double>(growth), 1e-9, source,
             "required: eight digits; tolerance 1e-12 per step");
    f.within(claim_name(subject, "least exponent per reflection", "event-driven"), "",
             exponent_of(found, 3) * static_cast<double>(flight), -static_cast<double>(growth), 1e-9,
             sum_source, "required: eight digits; tolerance 1e-12 per step");
    f.within(claim_name(subject, "sum of the exponents per reflection", "event-driven"), "",
             found.sum * static_cast<double>(flight), 0, 1e-9, sum_source,
             "differences at events of 1e-12 relative");
  }
}

/// The multipliers of the orbit that Newton's method finds, since the path itself is lost after some
/// reflections.
void three_discs_claims(Findings& f) {
  const long double a = 1, side = std::sqrt(3.0L);
  for (const double ratio : {2.5, 3.0, 6.0}) {
    const long double r = ratio, flight = reference::flight_round_three_discs(a, r);
    const long double out = r / side;  // of the centres
    const std::vector<Place> centres{{0, out}, {-r / 2, -out / 2}, {r / 2, -out / 2}};
    // From the middle of the flight between the two lower discs; slightly beside the path.
    const auto text = scatterer(centres, a, {2e-5L, -(out - a) / 2}, {1, 1e-5L}, 3 * flight);
    const auto found = orbit(parse_scene(text, "discs"),
                             {.periods = 1, .settle = 0, .period = static_cast<double>(3 * flight)});
    const auto subject = fmt::format("path round three discs, R/a = {:g}", ratio);
    const bool known = found.failure.empty() && found.multipliers.size() == 4;
    f.within(claim_name(subject, "exponent per reflection", "event-driven"), "",
             known ? std::log(std::abs(found.multipliers[0])) / 3 : NAN,
             static_cast<double>(std::log(reference::three_discs(a, r))), 1e-8,
             "curvature of wave fronts on a triangle of flights R - sqrt(3) a at 30 degrees",
             "required: eight digits; tolerance 1e-12 per step over the rate of the map");
  }
  // The same path in a run, for as long as it lasts.
  const long double r = 2.2L, flight = reference::flight_round_three_discs(a, r), out = r / side;
  const std::vector<Place> centres{{0, out}, {-r / 2, -out / 2}, {r / 2, -out / 2}};
  const auto text = scatterer(centres, a, {0, -(out - a) / 2}, {1, 0}, 20 * flight);
  const auto found =
      lyapunov(parse_scene(text, "discs"), {.batches = 4, .transient = static_cast<double>(16 * flight)});
  f.within(
      claim_name("path round three discs, R/a = 2.2", "greatest exponent per reflection", "event-driven"), "",
      exponent_of(found, 0) * static_cast<double>(flight),
      static_cast<double>(std::log(reference::three_discs(a, r))), 1e-6,
      "curvature of wave fronts on a triangle of flights R - sqrt(3) a at 30 degrees",
      "eight reflections align the vector to 2.7^-16, and 20 lose the path by 2.7^20 1e-16");
}

void billiard_claims(Findings& f) {
  const auto found =
      lyapunov(read_scene(test::scene_file("sinai_billiard")), {.batches = 40, .transient = 50});
  const auto expected = reference::SinaiBilliard{1, 0.5}.exponent(2'000'000, 1);
  const std::string subject = "point in a square with a disc (Sinai billiard)";
  const std::string source = "another program: ray tracing with the curvature of wave fronts";
  const double error = std::hypot(expected.error, found.failure.empty() ? found.exponents[0].error : NAN);
  f.within(claim_name(subject, "greatest exponent, difference from another program", "event-driven"), "1/s",
           exponent_of(found, 0) - expected.value, 0, 0.05, source,
           "four standard errors of the difference, about 0.86 1/s");
  f.at_most(claim_name(subject, "standard error of that difference", "event-driven"), "1/s", error, 0.0125,
            "batch means of both", "a quarter of the bound");
  f.within(claim_name(subject, "sum of the exponents", "event-driven"), "1/s", found.sum, 0, 1e-8,
           "conservation of volume", "differences at events of 1e-12 relative, 1.2 impacts per second");
  // The motion along the path and the energy: neutral, with errors that decrease with time.
  for (const std::size_t i : {1U, 2U})
    f.within(claim_name(subject, fmt::format("neutral exponent {}", i), "event-driven"), "1/s",
             exponent_of(found, i), 0, 1e-3, "shift along the path, and energy",
             "a neutral vector grows like the time: ln(2e4)/2e4 = 5e-4");
}

void ball_claims(Findings& f) {
  const long double omega = 20 * reference::ShakenBall::pi();
  reference::ShakenBall b{0, omega, 9.81L, 0.5L};
  b.amplitude = 0.99L * b.flip();  // real multipliers
  const auto pair = reference::multipliers(b.trace(), b.determinant());
  const auto found =
      lyapunov(parse_scene(scenes::shaken_ball(b, 0, 30), "ball"), {.batches = 10, .transient = 20});
  const std::string subject = "ball on a shaken table, period 1, 1 % below period doubling";
  const auto period = static_cast<double>(b.period());
  for (std::size_t i = 0; i < 2; ++i)
    f.within(claim_name(subject, fmt::format("exponent {} per period", i + 1), "event-driven"), "",
             exponent_of(found, i) * period, static_cast<double>(std::log(std::abs(pair[i]))), 1e-8,
             "logarithm of the multiplier in closed form",
             "required: eight digits; the motion nears its orbit as 0.93^200");
  f.within(claim_name(subject, "predicted sum per period", "event-driven"), "", found.predicted * period,
           2 * std::log(0.5), 1e-12, "2 ln e for each impact", "rounding");
  f.within(claim_name(subject, "sum of the exponents per period", "event-driven"), "", found.sum * period,
           2 * std::log(0.5), 1e-9, "2 ln e for each impact", "differences at events of 1e-12 relative");
}

}  // namespace

Parts lyapunov_exponents() {
  return {two_discs_claims, three_discs_claims, billiard_claims, ball_claims, attractor_exponents};
}

}  // namespace freeplay::verification
