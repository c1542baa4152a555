// Derivatives of peaks of instruments' signals: closed forms at interior peaks, at impacts and at
// the end of the run, and the low-pass of an accelerometer.
#include "analysis/sensitivity.hpp"
#include "verification/support/rig.hpp"
#include "verification/unit/variation/varied_scenes.hpp"

using namespace freeplay;
using Catch::Matchers::Contains;
using test::varied::check_derivatives;

namespace {

using std::numbers::pi;

/// A ball between two walls at x = −1 and x = right, without friction; it starts at x = 0.
std::string between_walls(double right, const std::string& velocity, double duration,
                          const std::string& instrument, const std::string& gravity = "[0, 0]") {
  return "gravity = " + gravity + "\n" +
         test::body("ball", 0.3, 3e-4, "position = [0, 0]\nvelocity = " + velocity + "\n") +
         test::plane("right", "ground", "ball", 0.05, "hard",
                     fmt::format("at = [[{}, 0], [0, 0]]\naxis = [0, 1]\nstiffness = 1e5\n", right)) +
         test::plane("left", "ground", "ball", 0.05, "hard",
                     "at = [[-1, 0], [0, 0]]\naxis = [0, -1]\nstiffness = 1e5\n") +
         test::surface("hard", 0.8) + instrument + test::run_for(duration, "start = \"given\"\n");
}

const std::string gauge =
    "[instruments.gauge]\ntype = \"lvdt\"\nbody = \"ball\"\naxis = [1, 0]\nsampling = 1e4\n";
const std::string pickup =
    "[instruments.pickup]\ntype = \"accelerometer\"\nbody = \"ball\"\naxis = [1, 0]\nbandwidth = 200\n"
    "order = 2\n"
    "sampling = 1e4\n";

Sensitivities of(const std::string& text, const std::string& quantity, std::vector<std::string> keys,
                 const std::string& formulation = "nonsmooth", const std::vector<std::string>& options = {}) {
  return sensitivities(parse_scene(text, "peak", options),
                       {.of = {quantity}, .to = std::move(keys), .formulation = formulation});
}

}  // namespace

TEST_CASE("peaks of positions have closed derivatives", "[sensitivity]") {
  // thrown against a constant force: x = v²/(2 g) at t = v/g, g = 4
  const auto thrown = of(between_walls(3, "[2, 0]", 0.9, gauge, "[-4, 0]"), "peak.gauge",
                         {"initial.ball.vx", "gravity[0]", "initial.ball.x"})
                          .quantities[0];
  CHECK(thrown.value == Approx(0.5).epsilon(1e-10));
  check_derivatives(thrown, {0.5, 4.0 / 32, 1}, 1e-9);
  // at the impact: x = right − radius, whatever the speed
  const auto hit =
      of(between_walls(0.6, "[2, 0]", 0.5, gauge), "peak.gauge",
         {"contacts.right.at[0][0]", "contacts.right.radius", "initial.ball.vx", "initial.ball.x"})
          .quantities[0];
  CHECK(hit.value == Approx(0.55).epsilon(1e-10));
  check_derivatives(hit, {1, -1, 0, 0}, 0, 1e-9);
  // at the end: x = v T
  const auto end =
      of(between_walls(3, "[2, 0]", 0.5, gauge), "peak.gauge", {"initial.ball.vx", "run.duration"})
          .quantities[0];
  CHECK(end.value == Approx(1).epsilon(1e-10));
  check_derivatives(end, {0.5, 2}, 1e-9);
}

TEST_CASE("peaks have derivatives with respect to their instrument", "[sensitivity]") {
  // The peak of a jump (1 + e) v of the velocity, as below, is proportional to the bandwidth. Behind an axis
  // (cos φ, sin φ) it is proportional to cos φ = a₀/√(a₀² + a₁²).
  const double peak = 1.8 * 2 * 2 * pi * 200 * std::exp(-pi / 4);
  const std::vector<std::string> keys{"instruments.pickup.bandwidth", "instruments.pickup.axis[1]",
                                      "surfaces.hard.restitution", "instruments.pickup.sampling"};
  const auto text = between_walls(0.6, "[2, 0]", 0.5, pickup);
  for (const bool stepped : {false, true}) {
    std::vector<std::string> options{"instruments.pickup.axis=[0.8, 0.6]"};
    if (stepped) options.insert(options.end(), {"nonsmooth.scheme=moreau-jean", "nonsmooth.step=1e-3"});
    const auto q = of(text, "peak.pickup", keys, "nonsmooth", options).quantities[0];
    CAPTURE(stepped);
    // quadrature of the low-pass, 1e-9, over a displacement of 5e-4
    check_derivatives(q, {0.8 * peak / 200, -0.6 * 0.8 * peak, 0.8 * peak / 1.8, 0}, 1e-5, 1e-300);
    CHECK_FALSE(std::signbit(q.derivatives[3]));
  }
  // A position: y of the ball at the peak of x, at the end.
  const auto place =
      of(between_walls(3, "[2, 0.5]", 0.5, gauge), "peak.gauge", {"instruments.gauge.axis[1]"}).quantities[0];
  CHECK(place.derivatives[0] == Approx(0.25).epsilon(1e-9));
}

TEST_CASE("two equal peaks have no derivative", "[sensitivity]") {
  const auto q =
      of(between_walls(1, "[2, 0]", 2.2, gauge), "peak.gauge", {"contacts.right.at[0][0]"}).quantities[0];
  CHECK(std::isnan(q.derivatives[0]));
  CHECK_THAT(q.reasons[0], Contains("two peaks of gauge are equal"));
  CHECK_THAT(test::refusal_of<std::exception>(
                 [] { of(between_walls(1, "[2, 0]", 1, gauge), "peak.x", {"gravity[0]"}); }),
             Contains("is no instrument of the scene"));
}

// A jump D of the velocity gives D ω √2 exp(−ωt/√2) sin(ωt/√2) behind a low-pass of second order,
// with its greatest value D ω exp(−π/4); D = (1 + e) v.
TEST_CASE("the peak of an accelerometer's signal has its closed derivatives", "[sensitivity]") {
  const double omega = 2 * pi * 200, peak = omega * std::exp(-pi / 4), e = 0.8, v = 2;
  const auto text = between_walls(0.6, "[2, 0]", 0.5, pickup);
  const std::vector<std::string> keys{"surfaces.hard.restitution", "initial.ball.vx", "bodies.ball.mass"};
  const auto check = [&](const Sensitivity& q, double bound) {
    CHECK(q.value == Approx((1 + e) * v * peak).epsilon(bound));
    check_derivatives(q, {v * peak, (1 + e) * peak, 0}, 0, bound * (1 + e) * peak);
  };
  // Quadrature of the low-pass, with ω h = 0.1: 1e-9 for each part.
  check(of(text, "peak.pickup", keys).quantities[0], 1e-8);
  // Free flight: the steps have no error but that of the impact's instant, which does not matter here.
  check(of(text, "peak.pickup", keys, "nonsmooth", {"nonsmooth.scheme=moreau-jean", "nonsmooth.step=1e-3"})
            .quantities[0],
        1e-6);
  // A range below the peak clips it.
  const auto clipped =
      of(text, "peak.pickup", keys, "nonsmooth", {"instruments.pickup.range=100"}).quantities[0];
  CHECK_THAT(clipped.reasons[0], Contains("exceeds the range"));
}

// Two impacts 0.625 ms apart: the second one turns the signal of the first, h(τ) = ω √2 exp(−ωτ/√2)
// sin(ωτ/√2), so that the peak is (1 + e) v h(τ) at the second impact, with τ = L/(e v) and L = 1
// mm.
TEST_CASE("a peak at an impact changes with the instants of the impacts", "[sensitivity]") {
  const double e = 0.8, v = 2, L = 1e-3, tau = L / (e * v), k = 2 * pi * 200 / std::sqrt(2.0);
  const double h = 2 * k * std::exp(-k * tau) * std::sin(k * tau),
               slope = 2 * k * k * std::exp(-k * tau) * (std::cos(k * tau) - std::sin(k * tau));
  auto text = between_walls(0.0505, "[2, 0]", 1.5e-3, pickup);
  text.replace(text.find("[[-1, 0]"), 8, "[[-0.0505, 0]");
  const auto q =
      of(text, "peak.pickup",
         {"surfaces.hard.restitution", "initial.ball.vx", "contacts.right.at[0][0]", "initial.ball.x"})
          .quantities[0];
  const double bound = 1e-8;  // as above
  CHECK(q.value == Approx((1 + e) * v * h).epsilon(bound));
  check_derivatives(
      q, {v * h - (1 + e) * v * slope * tau / e, (1 + e) * (h - slope * tau), (1 + e) * v * slope / (e * v)},
      bound);
  CHECK(std::abs(q.derivatives[3]) < bound * q.value / L);
}

// A ball dropped from rest: (1 + e) √(2 g H) ω exp(−π/4), less the weight, which passes the low-pass: −g.
TEST_CASE("the peak of a stepped impact under gravity converges", "[sensitivity]") {
  const std::string ball = "gravity = [-9.81, 0]\n" + test::body("ball", 0.3, 3e-4, "position = [0.5, 0]\n") +
                           test::plane("table", "ground", "ball", 0.05, "hard", "axis = [0, -1]\n") +
                           test::surface("hard", 0.5) + pickup + test::run_for(0.4, "start = \"given\"\n");
  const double H = 0.45, peak = 1.5 * std::sqrt(2 * 9.81 * H) * 2 * pi * 200 * std::exp(-pi / 4);
  const auto s = of(ball, "peak.pickup", {"initial.ball.x"}, "nonsmooth",
                    {"nonsmooth.scheme=moreau-jean", "nonsmooth.step=1e-3"});
  CHECK(s.quantities[0].value == Approx(peak - 9.81).epsilon(1e-6));
  CHECK(s.quantities[0].derivatives[0] == Approx(peak / (2 * H)).epsilon(1e-3));
}

TEST_CASE("the peak of an accelerometer's signal in a penalty run equals differences of runs",
          "[sensitivity]") {
  const auto text =
      between_walls(0.6, "[2, 0]", 0.4, pickup) + "[penalty]\nintegrator = \"dopri5\"\ntolerance = 1e-12\n";
  for (const std::string key : {"contacts.right.stiffness", "surfaces.hard.restitution"}) {
    const auto all = of(text, "peak.pickup", {key}, "penalty");
    const double p = all.key_values[0], h = 1e-3 * p;
    const auto at = [&](double x) {
      return of(text, "peak.pickup", {}, "penalty", {fmt::format("{}={:.17g}", key, x)}).quantities[0].value;
    };
    const double slope = (8 * (at(p + h) - at(p - h)) - (at(p + 2 * h) - at(p - 2 * h))) / (12 * h);
    CAPTURE(key);
    // error of the differences: 1e-10 of the value, a thousandth of which is the change
    CHECK(all.quantities[0].derivatives[0] == Approx(slope).epsilon(1e-6));
  }
}
