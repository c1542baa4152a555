// The references, compared with facts that none of them is computed from: derivatives by
// differences, quadrature, limits, balances, published values. All other verification depends on
// the references. Units are SI throughout.
#include <algorithm>
#include <boost/math/quadrature/tanh_sinh.hpp>
#include <boost/math/special_functions/jacobi_elliptic.hpp>
#include <boost/math/tools/toms748_solve.hpp>
#include <catch2/catch.hpp>
#include <cmath>
#include <random>
#include <string>

#include "verification/analytic/reference_checks.hpp"
#include "verification/references/block_on_slope.hpp"
#include "verification/references/bouncing_ball.hpp"
#include "verification/references/delivered_restitution.hpp"
#include "verification/references/hertz_impact.hpp"
#include "verification/references/loose_guide_flight.hpp"
#include "verification/references/oblique_impact.hpp"
#include "verification/references/pendulum.hpp"
#include "verification/references/ring_and_journal.hpp"
#include "verification/references/seven_body.hpp"
#include "verification/references/slider_crank.hpp"

using namespace freeplay::reference;

// ------------------------------------------------------------ slider-crank

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

TEST_CASE("slider-crank: greatest accelerations of the test rig and the angle at which they change sign",
          "[references]") {
  const double r = 0.05, l = 0.3;
  const double table[][2] = {{100, 6.40}, {150, 14.39}, {200, 25.59}, {250, 39.98}};
  for (const auto& [rpm, expected] : table) {
    const double speed = from_rpm(rpm);
    double greatest = 0;
    for (int i = 0; i <= 3600; ++i) {
      greatest = std::max(greatest, std::abs(slider_crank(r, l, i * pi / 1800, speed).acceleration));
    }
    within(greatest, expected, 0.005, "half the last digit of the table");
    within(greatest, slider_crank_greatest_acceleration(r, l, speed), 1e-12, rounding);
  }
  // Classical condition of greatest slider speed, N = l/r: S³ − N² S² − N⁴ S + N⁴ = 0 for S = sin²
  // φ.
  const auto zero = [&](double angle) { return slider_crank(r, l, angle, 1.0).acceleration; };
  std::uintmax_t most = 100;
  const auto root =
      boost::math::tools::toms748_solve(zero, 1.3, 1.5, boost::math::tools::eps_tolerance<double>(52), most);
  const double s = std::pow(std::sin(root.first), 2), nn = 36;
  within(s * s * s - nn * s * s - nn * nn * s + nn * nn, 0, 1e-11, "terms of 1300 to rounding");
  within(root.first / pi * 180, 80.783, 5e-4, "half the last digit of 80.783°, from second differences of x");
  within(zero(2 * pi - root.first), 0, 1e-15, "mirror");
}

// ------------------------------------------------------------ Hertz's
// impact

TEST_CASE("elastic impact: duration constant by quadrature, depth by energy", "[references]") {
  boost::math::quadrature::tanh_sinh<double> quadrature;
  for (const double n : {1.0, 1.3, 1.5, 2.0}) {
    // z = 1 − y² removes the singularity at z = 1.
    const auto f = [n](double y) {
      return y < 1e-9 ? 2 / std::sqrt(n + 1) : 2 * y / std::sqrt(-std::expm1((n + 1) * std::log1p(-y * y)));
    };
    within(impact_duration_constant(n), 2 * quadrature.integrate(f, 0.0, 1.0), 1e-12,
           "quadrature's own tolerance 1e-12");
  }
  within(impact_duration_constant(1), pi, 1e-14, "a linear spring: half a period");
  within(impact_duration_constant(1.5), 2.9432, 1e-4, "the published constant is cut off after four digits");

  const double stiffness = 1.055e11, mass = 0.8, speed = 0.113;
  const ElasticImpact hertz = elastic_impact(stiffness, mass, speed);
  within(hertz.depth / std::pow(5 * mass * speed * speed / (4 * stiffness), 0.4), 1, 1e-14, rounding);
  within(stiffness * std::pow(hertz.depth, 2.5) / 2.5 / (0.5 * mass * speed * speed), 1, 1e-14,
         "energy balance");
  const ElasticImpact linear = elastic_impact(3e4, mass, speed, 1);
  within(linear.depth, speed * std::sqrt(mass / 3e4), 1e-17, "v/ω of the oscillator");
  within(linear.duration, pi * std::sqrt(mass / 3e4), 1e-15, "π/ω of the oscillator");
  within(elastic_impact_speed(0.5 * linear.depth, linear.depth, speed, 1), speed * std::sqrt(0.75), 1e-15,
         "cos(asin ½)");
}

// ------------------------------------------------------------ delivered
// restitution

TEST_CASE("delivered restitution: table of the published laws", "[references]") {
  for (const DampingLaw& law : delivered_table) {
    for (std::size_t i = 0; i < delivered_table_e.size(); ++i) {
      INFO(law.name << ", e = " << delivered_table_e[i]);
      within(delivered_restitution(law.chi(delivered_table_e[i])), law.delivered[i], 0.501 * law.digit,
             "half the last digit kept");
    }
  }
  for (std::size_t i = 0; i < delivered_table_e.size(); ++i) {
    within(exact_chi(delivered_table_e[i]), exact_chi_table[i], 0.501e-5L, "half the last digit kept");
  }
}

TEST_CASE("delivered restitution: energy integral of the impact", "[references]") {
  boost::math::quadrature::tanh_sinh<double> quadrature;
  for (const double chi : {0.01, 0.3, 1.0, 1.66351, 4.0, 9.0}) {
    const double e = static_cast<double>(delivered_restitution(chi));
    // ∮ K δⁿ dδ = −m v₀² ∫ y dy/(1 + χ y) over y = δ̇/v₀ from 1 to −ê
    const auto f = [chi](double y) { return y / (1 + chi * y); };
    const double in = quadrature.integrate(f, 0.0, 1.0), out = -quadrature.integrate(f, -e, 0.0);
    within(in, out, 1e-9, "the integrand is as large as 1/(1 − χ ê) and costs that many digits of 1e-15");
    const Long depth = damped_impact_depth(1e10L, 0.5L, 0.2L, chi);
    within(1e10L * std::pow(depth, 2.5L) / 2.5L / (0.5L * 0.04L), in, 1e-13L, "quadrature to rounding");
  }
  within(damped_impact_depth(1e10L, 0.5L, 0.2L, 0), elastic_impact(1e10, 0.5, 0.2).depth, 1e-19L,
         "χ → 0 is Hertz");
}

TEST_CASE("delivered restitution: limits, inverse, conditioning", "[references]") {
  CHECK(delivered_restitution(0) == 1);
  CHECK(exact_chi(1) == 0);
  for (const Long chi : {1e-14L, 1e-9L, 1e-5L}) {
    within((1 - delivered_restitution(chi)) / chi, 2.0L / 3, chi + 1e-18L / chi,
           "ê = 1 − 2χ/3 + O(χ²), Hunt and Crossley's first order, and the rounding of 1 − ê over χ");
  }
  for (const Long chi : {50.0L, 1e3L, 1e9L}) {
    within(chi * delivered_restitution(chi), 1, 1e-18L,
           "1 − χ ê = (1 + χ) e^{−χ(1 + ê)} < 1e-20 from χ = 50 on");
  }
  for (const Long x : {-0.0499L, 0.0499L}) {
    within(separation_kernel(x), (x - std::log1p(x)) / (x * x), 1e-16L, "series and formula: ε x/x² = 2e-18");
  }
  Long last = 0;
  for (const Long e : {1e-4L, 0.01L, 0.1L, 0.46L, 0.9L, 0.999L, 1 - 1e-9L}) {
    const Long chi = exact_chi(e);
    within(delivered_restitution(chi), e, 2e-18L, "two bisections to neighbouring numbers, |dê/dχ| < 1");
    within(chi * (1 + e), std::log1p(chi) - std::log1p(-chi * e), 1e-12L + 1e-15L * (1 + e) / (1 / chi - e),
           "the equation as it is printed; the second term its conditioning near the pole");
    CHECK(e > last);
    CHECK((last == 0 || chi < exact_chi(last)));
    last = e;
  }
  CHECK_THROWS(exact_chi(0));
  CHECK_THROWS(delivered_restitution(-0.1L));
}

// ------------------------------------------------------------ pendulum

TEST_CASE("pendulum: period against known values", "[references]") {
  const auto ratio = [](double amplitude) {
    const Pendulum p{1.3, 0.07, 0.4, 9.81, amplitude};
    return pendulum_period(p) * p.small_rate() / (2 * pi);
  };
  const double quarter = std::tgamma(0.25);
  within(ratio(pi / 2), quarter * quarter / (2 * pi * std::sqrt(pi)), 1e-14, "K(1/√2) = Γ(¼)²/(4√π)");
  within(ratio(0.01), 1 + 1e-4 / 16, 1e-10, "1 + θ₀²/16 + 11 θ₀⁴/3072, the last term 4e-11");
  const double near = pi - 1e-6;
  within(ratio(near) * pi / 2, std::log(4 / std::cos(near / 2)), 2e-6,
         "K → ln(4/k′); 1 − k² = 2.5e-13 to the rounding 1e-19 of long double, times some");
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

// ------------------------------------------------------------ bouncing
// ball

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

// ------------------------------------------------------------ block on a
// slope

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

TEST_CASE("block on a slope: stopping, derived by hand", "[references]") {
  const double g = 10, alpha = std::asin(0.6);  // sin 0.6, cos 0.8
  const BlockOnSlope up{alpha, 0.5, g, 2};      // deceleration 6 + 4
  within(block_stopping_time(up).value(), 0.2, 1e-15, "2/10");
  within(block_stopping_distance(up).value(), 0.2, 1e-15, "4/20");
  within(block_state(up, 1.2).velocity, -2, 1e-14, "tan α = 0.75 > μ: slides back at 6 − 4");
  within(block_state(up, 1.2).position, 0.2 - 1, 1e-14, "½ · 2 · 1²");
  const BlockOnSlope down{alpha, 1.0, g, -1};  // −6 + 8
  within(block_stopping_time(down).value(), 0.5, 1e-14, "1/2");
  within(block_state(down, 3).position, -0.25, 1e-14, "1/4, and stays");
  CHECK(block_state(down, 3).velocity == 0);
  within(block_state(down, 3).friction, 6, 1e-14, "holds g sin α");
  CHECK_FALSE(block_stopping_time({alpha, 0.75 - 1e-9, g, -1}).has_value());
  CHECK_FALSE(block_stopping_time({0, 0, g, 1}).has_value());
  within(block_stopping_time({0, 0.2, g, 1}).value(), 0.5, 1e-15, "v/(μ g) on the level");
}

// ------------------------------------------------------------ oblique
// impact

TEST_CASE("oblique impact: a disc on the ground", "[references]") {
  const double m = 2, radius = 0.1, inertia = 0.5 * m * radius * radius, u_n = -3, e = 0.7;
  const Delassus<double> d = body_on_ground(m, inertia, 0, -radius);
  within(d.tt, 3 / m, 1e-14, "solid disc: 1/m + R²/J");
  CHECK(d.nt == 0);
  for (const double mu : {0.0, 0.05, 0.3}) {
    // friction changes u_T by at most D_TT μ (1 + e) |u_N| m
    const double edge = 3 * mu * (1 + e) * 3;
    for (const double u_t : {-20.0, -0.999 * edge, 0.0, 0.999 * edge, 1.001 * edge, 20.0}) {
      const auto p = oblique_impact(d, u_n, u_t, e, mu);
      within(p.impulse_n, m * (1 + e) * 3, 1e-13, "uncoupled normal");
      if (std::abs(u_t) < edge) {
        CHECK(p.kind == ImpactCase::stick);
        within(p.impulse_t, -m * u_t / 3, 1e-13, "the impulse that makes it roll");
        CHECK(p.u_t == 0);
      } else {
        CHECK(p.kind == ImpactCase::slip);
        within(p.u_t, u_t - std::copysign(edge, u_t), 1e-13, "slides on, slowed by D_TT μ P_N");
      }
      // Newton and Euler on the disc itself
      const double v = u_t + p.impulse_t / m, spin = radius * p.impulse_t / inertia;
      within(v + radius * spin, p.u_t, 1e-13, "velocity of the contact point from the body's own");
      CHECK(kinetic_energy_gain(p, u_n, u_t) <= 1e-12);
    }
  }
  CHECK(oblique_impact(d, 0.1, 1.0, e, 0.3).kind == ImpactCase::none);
}

TEST_CASE("oblique impact: a rod, slip reversal", "[references]") {
  // A rod of length 2a at 45°, with its lower end in contact: D = [1 + 3/2, ∓3/2; …, 1 + 3/2]/m for
  // J = m a²/3.
  const double m = 1.2, a = 0.3, inertia = m * a * a / 3, x = a / std::sqrt(2), y = -x;
  const Delassus<double> d = body_on_ground(m, inertia, x, y);
  within(d.nn * m, 2.5, 1e-14, "1 + m x²/J");
  within(d.nt * m, 1.5, 1e-14, "−m x y/J");
  // Without friction the impact gives the end a velocity of D_NT P_N = 0.6 (1 + e) |u_N|, here 0.9
  // m/s along +x.
  const auto free = oblique_impact(d, -1.0, -0.5, 0.5, 0.0);
  within(free.u_t, -0.5 + 0.9, 1e-14, "frictionless");
  const auto p = oblique_impact(d, -1.0, -0.5, 0.5, 0.1);
  CHECK(p.kind == ImpactCase::reversed_slip);
  within(p.impulse_n, 1.5 * m / (2.5 - 0.15), 1e-14, "(1 + e) |u_N|/(D_NN − μ D_NT)");
  within(p.u_t, -0.5 + (1.5 - 0.25) / m * p.impulse_n, 1e-14, "u_T + (D_NT − μ D_TT) P_N");
  CHECK(oblique_impact(d, -1.0, -0.5, 0.5, 0.4).kind == ImpactCase::stick);
  CHECK(oblique_impact(d, -1.0, -5.0, 0.5, 0.1).kind == ImpactCase::slip);
  // the rod's own motion
  const double vx = p.impulse_t / m, vy = p.impulse_n / m;
  const double spin = (x * p.impulse_n - y * p.impulse_t) / inertia;
  within(vy + spin * x, p.u_n + 1.0, 1e-13, "normal velocity of the end from the body's own");
  within(vx - spin * y, p.u_t + 0.5, 1e-13, "tangential velocity of the end from the body's own");
  CHECK_THROWS(oblique_impact(Delassus<double>{1, 3, 20}, -1.0, 0.0, 0.5, 0.5));
}

TEST_CASE("oblique impact: the law on random contacts, and its limits", "[references]") {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> unit(-1, 1);
  int seen[4] = {};
  for (int i = 0; i < 20000; ++i) {
    const double nn = 1.5 + unit(random), tt = 3 + 2 * unit(random),
                 nt = 0.9 * unit(random) * std::sqrt(nn * tt);
    const double mu = 0.6 * (1 + unit(random)), e = 0.5 * (1 + unit(random)),
                 u_n = -0.55 + 0.5 * unit(random);
    const double u_t = unit(random);
    const Delassus<double> d{nn, nt, tt};
    if (nn < 1.05 * mu * std::abs(nt)) continue;
    const auto p = oblique_impact(d, u_n, u_t, e, mu);
    ++seen[static_cast<int>(p.kind)];
    const double bound = 1e-12;  // entries of D⁻¹ and of P up to 1e3
    REQUIRE(std::abs(p.u_n + e * u_n) < bound);
    REQUIRE(std::abs(u_n + nn * p.impulse_n + nt * p.impulse_t - p.u_n) < bound);
    REQUIRE(std::abs(u_t + nt * p.impulse_n + tt * p.impulse_t - p.u_t) < bound);
    REQUIRE(p.impulse_n > 0);
    REQUIRE(std::abs(p.impulse_t) <= mu * p.impulse_n * (1 + 1e-12));
    REQUIRE(std::abs(p.u_t) * (mu * p.impulse_n - std::abs(p.impulse_t)) <
            bound);                     // full friction where it slides
    REQUIRE(p.impulse_t * p.u_t <= 0);  // against it
    REQUIRE((p.kind == ImpactCase::reversed_slip) == (p.u_t * u_t < 0));
    // Uniqueness permits a second method: the sticking impulse limited to the cone.
    const double a = -(1 + e) * u_n, stick = (-nn * u_t - nt * a) / (nn * tt - nt * nt);
    const double cut = std::clamp(stick, -mu * a / (nn - mu * nt), mu * a / (nn + mu * nt));
    REQUIRE(std::abs(p.impulse_t - cut) <
            1e-9);  // at an edge both methods divide by numbers as small as 0.05 nn
  }
  CHECK(std::min({seen[1], seen[2], seen[3]}) > 100);
  const Delassus<double> d{1.5, 0.4, 3};
  within(oblique_impact(d, -1.0, 0.7, 0.5, 1e-12).u_t, oblique_impact(d, -1.0, 0.7, 0.5, 0.0).u_t, 1e-11,
         "μ → 0");
  CHECK(oblique_impact(d, -1.0, 0.7, 0.5, 3.0).kind == ImpactCase::stick);
  CHECK(oblique_impact(d, -1.0, 0.7, 0.0, 0.1).u_n == 0);
  within(kinetic_energy_gain(oblique_impact(d, -1.0, 0.7, 1.0, 0.0), -1.0, 0.7), 0, 1e-15,
         "e = 1 without friction loses nothing");
}

// ------------------------------------------------------------ ring and
// journal

TEST_CASE("ring and journal: flight to the wall", "[references]") {
  const double c = 2.5e-4;
  for (const double angle : {0.0, 1.0, 2.5, 4.0}) {
    for (const double start : {0.0, 0.3, 0.999}) {
      const Plane e{start * c, 0}, rate{0.1 * std::cos(angle), 0.1 * std::sin(angle)};
      const double t = time_to_contact(e, rate, c).value();
      CHECK(t > 0);
      within(std::hypot(e[0] + t * rate[0], e[1] + t * rate[1]) / c, 1, 1e-12,
             "on the wall; at 0.999 c the root cancels 1e3");
      const double before = 0.999 * t;
      CHECK(std::hypot(e[0] + before * rate[0], e[1] + before * rate[1]) < c);
    }
  }
  within(time_to_contact({0, 0}, {0.1, 0}, c).value(), 2.5e-3, 1e-17, "c/v from the centre");
  CHECK_FALSE(time_to_contact({0, 0}, {0, 0}, c).has_value());
  const double w = 0.03, u = 0.05;
  within(time_to_contact({c, 0}, {-w, u}, c).value(), chord(c, w, u).duration, 1e-15, "the whole chord");
  const double t = chord(c, w, u).duration;
  within(std::atan2(u * t, c - w * t), chord(c, w, u).turn, 1e-13, "angle at the centre");
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

// ------------------------------------------------------------ seven bodies

TEST_CASE("seven-body mechanism: the published positions close the loops", "[references]") {
  for (const auto& angles : {seven_body_start, seven_body_end}) {
    const auto p = seven_body_points(angles);
    for (int chain = 1; chain < 4; ++chain)
      within(std::abs(p[0] - p[chain]), 0, 1e-14, "15 digits of links below 0.07 m");
  }
}

TEST_CASE("seven-body mechanism: the rates are the derivatives of the closed loops", "[references]") {
  // The other angles follow from β by the loops: a step along the rates keeps them closed to second
  // order.
  const auto rates = seven_body_rates(seven_body_end, 1.0);
  double errors[2];
  for (int i = 0; i < 2; ++i) {
    auto moved = seven_body_end;
    const double h = i == 0 ? 2e-4 : 1e-4;
    for (int k = 0; k < 7; ++k) moved[k] += h * rates[k];
    const auto p = seven_body_points(moved);
    errors[i] = std::abs(p[0] - p[1]) + std::abs(p[0] - p[2]) + std::abs(p[0] - p[3]);
  }
  within(errors[0] / errors[1], 4, 0.01, "second order in the step; the third adds h times a few");
}

TEST_CASE("seven-body mechanism: kinetic energy equals that of points along the bodies", "[references]") {
  // König's theorem by differences of the centres of mass along the rates.
  const auto rates = seven_body_rates(seven_body_end, 1.0);
  const double h = 1e-6;
  auto ahead = seven_body_end, behind = seven_body_end;
  for (int k = 0; k < 7; ++k) {
    ahead[k] += h * rates[k];
    behind[k] -= h * rates[k];
  }
  const auto a = seven_body_centres(ahead), b = seven_body_centres(behind);
  const double turn[] = {rates[0], rates[0] + rates[1], rates[2], rates[3] + rates[4],
                         rates[4], rates[5] + rates[6], rates[6]};
  double energy = 0;
  for (int k = 0; k < 7; ++k)
    energy += 0.5 * seven_body_masses[k] * std::norm((a[k] - b[k]) / (2 * h)) +
              0.5 * seven_body_inertias[k] * turn[k] * turn[k];
  within(energy / (0.5 * seven_body_inertia(seven_body_end)), 1, 1e-8, "rounding 1e-16/h of lengths 0.07 m");
}
