// The references, compared with facts that none of them is computed from: derivatives by
// differences, limits, balances, published values. All other verification depends on
// the references. Units are SI throughout.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "verification/references/block_on_slope.hpp"
#include "verification/references/bouncing_ball.hpp"
#include "verification/references/loose_guide_flight.hpp"
#include "verification/references/pendulum.hpp"
#include "verification/references/ring_and_journal.hpp"
#include "verification/references/seven_body.hpp"
#include "verification/references/slider_crank.hpp"
#include "verification/unit/references/reference_checks.hpp"

using namespace freeplay::reference;

TEST_CASE("slider-crank: the rates are the derivatives of the closed loop", "[references]") {
  const Long r = 0.05L, l = 0.3L, speed = from_rpm(200.0L);
  for (Long phi = -3; phi < 7; phi += 0.37L) {
    const auto at = [&](Long t) { return slider_crank(r, l, phi + speed * t, speed); };
    const auto m = at(0);
    const char* closure = "the loop r e^{iφ} + l e^{iθ} = x closes to the rounding of long double";
    within(r * std::cos(phi) + l * std::cos(m.rod_angle), m.x, 1e-18L, closure);
    within(r * std::sin(phi) + l * std::sin(m.rod_angle), 0, 1e-18L, closure);
    const Long h = 1e-5L;
    const char* why =
        "h⁴ ω⁵ l/30 = 1e-16 of truncation, ε l/h = 3e-15 of rounding, times ω for the second derivative";
    within(slope([&](Long t) { return at(t).x; }, 0, h), m.velocity, 1e-13L, why);
    within(slope([&](Long t) { return at(t).rod_angle; }, 0, h), m.rod_rate, 1e-13L, why);
    within(slope([&](Long t) { return at(t).velocity; }, 0, h), m.acceleration, 3e-12L, why);
    within(slope([&](Long t) { return at(t).rod_rate; }, 0, h), m.rod_acceleration, 3e-12L, why);
  }
}

TEST_CASE("pendulum: equation of motion, energy, symmetry", "[references]") {
  for (const double amplitude : {0.01, 1.0, -2.0, 3.1}) {
    const Pendulum p{1.3, 0.07, 0.4, 9.81, amplitude};
    const double w = p.small_rate(), period = pendulum_period(p);
    within(p.small_rate() * p.small_rate() * (0.07 + 1.3 * 0.16), 1.3 * 9.81 * 0.4, 1e-14, rounding);
    for (int i = 0; i <= 40; ++i) {
      const double t = i * 0.0731 * period;
      const PendulumState s = pendulum_state(p, t);
      const Long h = 1e-3L / w;
      const char* why = "h⁴/30 of the fifth derivative in units of 1/ω₀ ≤ 1e-11, rounding 1e-15/1e-3";
      within(slope([&](Long x) { return Long(pendulum_state(p, double(x)).angle); }, t, h) / w, s.rate / w,
             2e-11L, why);
      within(slope([&](Long x) { return Long(pendulum_state(p, double(x)).rate); }, t, h) / (w * w),
             -std::sin(s.angle), 2e-11L, why);
      within(s.rate * s.rate / 2 / (w * w), std::cos(s.angle) - std::cos(amplitude), 1e-13,
             "energy, to rounding");
      const PendulumState half = pendulum_state(p, t + period / 2);
      within(half.angle, -s.angle, 2e-12,
             "half a period later on the other side; t rounds, and the rate amplifies");
    }
    within(pendulum_state(p, 0).angle, amplitude, 1e-14, "release");
    within(pendulum_state(p, period / 4).angle, 0, 1e-13, "the bottom after a quarter");
  }
  const Pendulum small{1.3, 0.07, 0.4, 9.81, 1e-4};
  within(pendulum_state(small, 0.7).angle, 1e-4 * std::cos(small.small_rate() * 0.7), 1e-11,
         "linear limit: period longer by θ₀²/16, ω₀ t θ₀³/16 = 3e-13");
}

TEST_CASE("bouncing ball: closed form against the recursion from bounce to bounce", "[references]") {
  for (const double e : {0.0, 0.3, 0.8, 0.999, 1.0}) {
    const BouncingBall ball{1.7, 9.81, e};
    double t = std::sqrt(2 * 1.7 / 9.81), v = std::sqrt(2 * 9.81 * 1.7);
    for (int k = 1; k <= 30; ++k) {
      const BallImpact impact = ball_impact(ball, k);
      within(impact.t, t, 1e-13, "sixty roundings of numbers near thirty");
      within(impact.approach, v, 1e-13, "thirty roundings of numbers near six");
      within(impact.rebound, e * v, 1e-13, "thirty roundings of numbers near six");
      within(ball_height(ball, impact.t), 0, 1e-12, "on the floor");
      const double top = ball_height(ball, impact.t + impact.rebound / 9.81);
      within(top, 1.7 * std::pow(e, 2 * k), 1e-12, "energy: each bounce keeps e² of the height");
      t += 2 * e * v / 9.81;
      v *= e;
    }
  }
}

TEST_CASE("bouncing ball: accumulation point and limits", "[references]") {
  const BouncingBall ball{1, 10, 0.5};
  within(ball_accumulation_time(ball), 3 * std::sqrt(0.2), 1e-15, "t₁ (1 + e)/(1 − e)");
  const std::vector<BallImpact> all = ball_impacts(ball, 100, 50);
  REQUIRE(all.size() == 50);
  within(all.back().t, ball_accumulation_time(ball), 1e-14, "2⁻⁴⁹ of the way left");
  CHECK(std::is_sorted(all.begin(), all.end(), [](auto& a, auto& b) { return a.t < b.t; }));
  CHECK(ball_height(ball, 1.5) == 0);
  CHECK(ball_impacts(ball, 1.0).size() == 2);  // 0.447, 0.894, 1.118
  CHECK(ball_impacts({1, 10, 0}, 100).size() == 1);
  CHECK(ball_accumulation_time({1, 10, 0}) == ball_impact({1, 10, 0}, 1).t);
  CHECK(std::isinf(ball_accumulation_time({1, 10, 1})));
  // The energy lost over all bounces is that of the whole drop.
  double lost = 0;
  for (const BallImpact& i : all) lost += 0.5 * (i.approach * i.approach - i.rebound * i.rebound);
  within(lost, 10 * 1, 1e-13, "½ Σ (v² − e² v²) = g H, but for 4⁻⁵⁰ of it");
}

TEST_CASE("slider with clearance in its guide: the flight conserves energy and agrees with another program",
          "[references]") {
  const LooseGuide m;
  const auto y = guide_flight(m, 0.002L), fine = guide_flight(m, 0.002L, 400);
  const char* why = "order 8: (150 rad/s × 1e-5 s)⁸ is 3e-23; rounding of 200 steps";
  for (std::size_t i = 0; i < 4; ++i) within(y[i], fine[i], 1e-16L * (1 + std::abs(fine[i])), why);
  const Long before = guide_energy(m, guide_start);
  within(guide_energy(m, y), before, 1e-16L * before, why);
  within(y[0] / (2 * std::acos(-1.0L)), 0.04389404441618265L, 1e-13L, "the other program's tolerance, 1e-12");
  within(y[1], -0.1349492638658336L, 1e-12L, "as above");
  within(y[2], 120.46388171355167L, 1e-10L, "as above");
  within(y[3], -56.47339414244658L, 1e-10L, "as above");
  within(guide_height(m, y), 0.4943955541187525L, 1e-9L, "as above, over 1 mm");
}

TEST_CASE("block on a slope: motion, energy, limit of sticking", "[references]") {
  const double g = 9.81;
  for (const double mu : {0.0, 0.2, 0.8}) {
    for (const double alpha : {0.0, 0.3, 0.6}) {
      for (const double v0 : {-1.5, 0.0, 1.5}) {
        const BlockOnSlope b{alpha, mu, g, v0};
        double work = 0, last = 0;  // of friction, per mass
        for (int i = 0; i <= 2000; ++i) {
          const double t = i * 1e-3;
          const BlockState s = block_state(b, t);
          // Friction is constant between stops, so its work over a piece is exact unless the piece
          // contains a stop.
          if (i > 0) work += block_state(b, t - 0.5e-3).friction * (s.position - last);
          last = s.position;
          within(0.5 * s.velocity * s.velocity + g * std::sin(alpha) * s.position - work, 0.5 * v0 * v0, 2e-4,
                 "kinetic + potential = initial + work, but for a piece with a stop: 2 μ g ½ |s̈| (1e-3)² ≤ "
                 "2e-4");
          CHECK(s.friction * s.velocity <= 1e-15);
          CHECK(std::abs(s.friction) <= mu * g * std::cos(alpha) + 1e-15);
        }
      }
    }
  }
  CHECK(BlockOnSlope{0.3, std::tan(0.3) + 1e-12, g, 0}.sticks());
  CHECK_FALSE(BlockOnSlope{0.3, std::tan(0.3) - 1e-12, g, 0}.sticks());
}

TEST_CASE("ring and journal: momentum and energy over many impacts", "[references]") {
  for (const double restitution : {1.0, 0.8, 0.46}) {
    const RingAndJournal pair{1.3, 0.7, 2.5e-4, restitution};
    PairState s{0, {0.01, -0.02}, {0.01 + 1e-4, -0.02 - 5e-5}, {0.02, 0.01}, {0.1, 0.07}};
    const PairLedger start = pair_ledger(pair, s);
    double lost = 0, w = 0, u = 0;
    for (int k = 0; k < 12; ++k) {
      const double flight = time_to_contact(s.eccentricity(), s.rate(), pair.clearance).value();
      // Coordinates near 0.02 m round by 1e-17 m in a few sums; divided by the chord's length along
      // the normal.
      const double bound = 1e-12 + 1e-17 * (w * w + u * u) / (2 * pair.clearance * w * w);
      if (k > 0) within(flight / chord(pair.clearance, w, u).duration, 1, bound, "chords in closed form");
      const PairImpact impact = pair_impact(pair, after_flight(s, flight));
      lost += impact.energy_lost;
      if (k > 0) within(impact.approach / w, 1, bound, "same speed at both ends of a chord");
      s = impact.after;
      const Plane e = s.eccentricity(), v = s.rate();
      w = -dot(e, v) / pair.clearance;
      u = cross(e, v) / pair.clearance;
      within(w, restitution * impact.approach, 1e-12, "restitution");
    }
    const PairLedger end = pair_ledger(pair, s);
    within(end.momentum[0], start.momentum[0], 1e-15, rounding);
    within(end.momentum[1], start.momentum[1], 1e-15, rounding);
    within(end.angular_momentum, start.angular_momentum, 1e-16, "frictionless, 0.01 kg m/s at 0.02 m");
    within(end.energy + lost, start.energy, 1e-15, "kinetic + lost");
    if (restitution == 1) within(end.energy, start.energy, 1e-15, "nothing lost at ε = 1");
  }
  // With the ring fixed, the journal alone bounces.
  const PairImpact wall = pair_impact({1e12, 0.7, 1e-3, 0.5}, {0, {0, 0}, {1e-3, 0}, {0, 0}, {0.2, 0.3}});
  within(wall.after.journal_velocity[0], -0.1, 1e-11, "m₁ → ∞");
  within(wall.after.journal_velocity[1], 0.3, 1e-15, "no friction");
}

TEST_CASE("seven-body mechanism: the published positions close the loops", "[references]") {
  for (const auto& angles : {seven_body_start, seven_body_end}) {
    const auto p = seven_body_points(angles);
    for (int chain = 1; chain < 4; ++chain)
      within(std::abs(p[0] - p[chain]), 0, 1e-14, "15 digits of links below 0.07 m");
  }
}
