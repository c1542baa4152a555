// Redundant constraints on a determinate motion; the work of drives in adaptive time stepping; a
// spring whose length passes through zero; kinks of tables over speed. Each case runs by every
// method, against closed forms.
#include "values/warning.hpp"
#include "verification/support/named.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;
using Catch::Matchers::Contains;

namespace {

using test::Way, test::finished;

Way every_way() {
  return GENERATE(
      values<Way>({test::penalty, test::event_driven, test::chosen_steps, test::fixed_steps(1e-4)}));
}
bool doubtful(const Result& run) { return std::ranges::any_of(run.notes, is_warning); }

std::filesystem::path scene(const std::string& name) { return test::scene_file("tests/" + name); }

}  // namespace

TEST_CASE("two consistent drives over ideal gears run, loaded or not, and the redundancy is reported",
          "[twice][drives]") {
  const auto way = every_way();
  const bool loaded = GENERATE(false, true);
  CAPTURE(way.name, loaded);
  const auto run =
      finished(way, scene("two_motors"),
               loaded ? std::vector<std::string>{"loads.brake={type=\"torque\", body=\"b\", torque=3}"}
                      : std::vector<std::string>{});
  // θ = ω t to a thousand roundings of 10 rad; nothing accelerates, so both drives together balance
  // the brake.
  CHECK(run.final_state.q[2] == Approx(10).epsilon(1e-12));
  CHECK(run.final_state.q[5] == Approx(-5).epsilon(1e-12));
  CHECK(run.ledger.drive == Approx(loaded ? 15 : 0).margin(1e-9));
  CHECK_THAT(test::notes_of(run), Contains("are linearly dependent"));
  CHECK_FALSE(doubtful(run));
}

TEST_CASE("two contradicting drives over gears are refused when the scene is read", "[twice][errors]") {
  const auto way = every_way();
  CHECK_THROWS_WITH(finished(way, scene("two_motors"), {"drives.second.speed=-6"}),
                    Contains("no velocities satisfy all constraints"));
}

TEST_CASE("adaptive time stepping records the work of a drive", "[chosen][drives]") {
  SECTION("a body lifted along a curve: the work is the change of energy at any step size") {
    // m g s with s = 0.05 m in the middle of the dwell of the third period, where the speed is 0.
    // To rounding: steps are exact.
    const auto run = finished(test::chosen_steps, scene("lifted_body"));
    CHECK(run.ledger.drive == Approx(2 * 9.81 * 0.05).epsilon(1e-9));
    CHECK(std::abs(run.ledger.stabilisation) <= 1e-9);
    CHECK_FALSE(doubtful(run));
  }
  SECTION("a body that returns to rest at its start: no doubtful result") {
    for (const auto& way : {test::penalty, test::event_driven, test::chosen_steps}) {
      CAPTURE(way.name);
      CHECK_FALSE(doubtful(finished(way, scene("lifted_body"), {"joints.g.axis=[1, 0]", "run.duration=3"})));
    }
  }
  SECTION("a slider-crank at constant speed: the work is the change of kinetic energy") {
    const auto energy = [](double angle) {
      const double w = 50, sine = -0.25 * std::sin(angle), cosine = std::sqrt(1 - sine * sine);
      const double turning = -0.25 * w * std::cos(angle) / cosine;
      const double x = -0.1 * w * std::sin(angle) - 0.2 * turning * sine,
                   y = 0.1 * w * std::cos(angle) + 0.2 * turning * cosine;
      const double slide = -0.1 * w * std::sin(angle) - 0.4 * turning * sine;
      return 0.5 * (0.01 * w * w + x * x + y * y + 0.03 * turning * turning + 2 * slide * slide);
    };
    const auto run = finished(test::chosen_steps, scene("fast_slider_crank"));
    // Two hundred steps of 1e-6 of the speed each: 4e-4 of the energies. A run reports an error
    // from a thousandth on.
    CHECK(run.ledger.drive == Approx(energy(50) - energy(0)).margin(4e-4 * energy(0)));
    CHECK(std::abs(run.ledger.stabilisation) <= 4e-4 * energy(0));
    CHECK_FALSE(doubtful(run));
  }
}

TEST_CASE("a slider that passes the zero length of a spring turns back on the far side", "[twice][springs]") {
  // m ẍ = −k (|x| − L) sgn x, from rest at L + A: harmonic about ±L either side, with ω = √(k/m).
  // From L + A to 0 it takes t₁ = (π/2 + asin(L/A))/ω, and by symmetry 2 t₁ to rest at −(L + A), 4
  // t₁ back to the start.
  const auto way = every_way();
  const double L = GENERATE(0.0, 0.1), A = 0.25, k = 50, m = 2, w = std::sqrt(k / m);
  const double t1 = (std::acos(-1) / 2 + std::asin(L / A)) / w;
  CAPTURE(way.name, L);
  const auto at = [&](double t) {
    return finished(way,
                    "format = 2\n" + test::body("b", 2, 0.01) + test::guide("guide", "ground", "b") +
                        test::spring("spring", "ground", "b", {}, {}, k, L) + test::run_for(t),
                    {fmt::format("bodies.b.position=[{}, 0]", L + A)})
        .final_state;
  };
  // Half way between 0 and the far end, and a full period later. Tolerances of 1e-9 (adaptive time
  // stepping 1e-6) times some hundred steps; the middle of a fixed step is up to h/2 beside the
  // position, where the force jumps by 2 k L: the error of v is up to k L h/m at each pass, and
  // that of x up to that over 1/ω more.
  const double h = 1e-4, far = 2 * k * L * h / m / w;
  const double bound = way.fixed() ? 3 * far + 0.25 * w * w * h * h * 10 : way.chosen() ? 1e-4 * A : 1e-6 * A;
  const double late = 1.5 * t1;
  const double x = -(L + A * std::cos(w * (2 * t1 - late)));
  CHECK(at(late).q[0] == Approx(x).margin(bound));
  const auto back = at(4 * t1);
  CHECK(back.q[0] == Approx(L + A).margin(3 * bound));
  CHECK(back.v[0] == Approx(0).margin(3 * w * bound + 1e-5));
}

TEST_CASE("a kink in a damper's table over speed does not reduce the order of any method",
          "[twice][springs]") {
  // m v̇ = −D(v), D = 1 v up to 1 m/s, then 1 + 9 (v − 1): from 3 m/s exponential to v = 1, v + (…)
  // of rate 9/m about v₀ = 8/9, at T = (m/9) ln((3 − 8/9)/(1/9)), then exp(−(t − T)/m).
  const auto way = every_way();
  CAPTURE(way.name);
  const double m = 2, T = m / 9 * std::log((3 - 8.0 / 9) * 9);
  const double end = 1.5;
  REQUIRE(T < end);
  const double v = std::exp(-(end - T) / m);
  const auto off = [&](const test::Way& by) {
    return std::abs(finished(by, scene("slider_with_kinked_damper")).final_state.v[0] - v);
  };
  if (!way.fixed()) {  // a thousand steps of tolerance 1e-9 (adaptive time stepping 1e-6)
    CHECK(off(way) <= (way.chosen() ? 1e-3 : 1e-6));
    return;
  }
  // Second order on average: the position of the kink within its step is random, so over a factor
  // of 16 together, within one order.
  const double coarse = off(test::fixed_steps(1.6e-2)), fine = off(test::fixed_steps(1e-3));
  const double order = std::log(coarse / fine) / std::log(16.0);
  CHECK(order > 1.5);
  CHECK(order < 2.6);
}
