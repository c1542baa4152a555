// References, compared with published values and results that none of them is computed from. Their further
// values are compared with those of the program by claims. Units are SI throughout.
#include <boost/math/special_functions/jacobi_elliptic.hpp>
#include <boost/math/tools/toms748_solve.hpp>
#include <catch2/catch.hpp>
#include <cmath>
#include <string>

#include "verification/references/delivered_restitution.hpp"
#include "verification/references/hertz_impact.hpp"
#include "verification/references/loose_guide.hpp"
#include "verification/references/seven_body.hpp"
#include "verification/references/slider_crank_oracle.hpp"

using namespace freeplay::reference;

namespace {

using Long = long double;
using Mechanism = LooseSliderCrank<Long>;
using State = LooseState<Long>;

void within(Long measured, Long expected, Long bound, const std::string& why) {
  INFO("measured " << measured << ", expected " << expected << ", bound " << bound << ": " << why);
  CHECK(std::abs(measured - expected) <= bound);
}

/// Distance of the pin's centre x from the bearing's, the rod's end, at the time t and rod angle θ.
Long distance(const Mechanism& m, Long t, Long theta, Long x) {
  const Long phi = m.start_angle + m.speed * t;
  return std::hypot(x - m.crank_length * std::cos(phi) - m.rod_length * std::cos(theta),
                    m.crank_length * std::sin(phi) + m.rod_length * std::sin(theta));
}

/// Free flight from the ideal start at φ₀ = 0, where ψ = φ − θ is a rotating pendulum:
///
///     sin(ψ/2) = sn(ψ̇₀ t/2, k).
State closed_flight(const Mechanism& m, Long t) {
  const Long rate = m.speed * (1 + m.crank_length / m.rod_length);
  const Long stiffness =
      m.rod_mass * m.rod_centre * m.crank_length * m.speed * m.speed / m.rod_inertia_about_pin();
  Long cn = 1, dn = 1;
  const Long sn = boost::math::jacobi_elliptic(2 * std::sqrt(stiffness) / rate, rate * t / 2, &cn, &dn);
  return {m.speed * t - 2 * std::atan2(sn, cn), m.speed - rate * dn, m.crank_length + m.rod_length, 0, 0, 0};
}

}  // namespace

TEST_CASE("oracle: flight and first contact agree with elliptic functions", "[references]") {
  Mechanism m;
  const char* why = "a dozen roundings of numbers of order one in long double; the modulus costs 1/k′²";
  const OracleRun<Long> before = SliderCrankOracle<Long>(m).nonsmooth(0.46L, 4.4e-3L);
  CHECK(before.impacts.empty());
  CHECK((before.end == OracleEnd::end_time && before.t == 4.4e-3L));
  for (const std::size_t i : {0u, 1u, 2u, 3u})
    within(before.state[i], closed_flight(m, 4.4e-3L)[i], 3e-17L, why);

  const auto gap = [&](Long t) {
    return m.clearance - distance(m, t, closed_flight(m, t)[0], closed_flight(m, t)[2]);
  };
  std::uintmax_t most = 200;
  const auto root =
      boost::math::tools::toms748_solve(gap, 4e-3L, 5e-3L, boost::math::tools::eps_tolerance<Long>(62), most);
  m.friction = 0.01L;
  const OracleRun<Long> run = SliderCrankOracle<Long>(m).nonsmooth(0.46L, 0.02L);
  REQUIRE(run.impacts.size() > 5);
  const OracleImpact<Long>& first = run.impacts[0];
  within(first.t, root.first, 1e-17L, "rounding of e, 1e-19 m, over 0.11 m/s, and that of θ");
  const Long t = root.first, h = 1e-6L;
  const Long slope = (8 * (gap(t + h) - gap(t - h)) - (gap(t + 2 * h) - gap(t - 2 * h))) / (12 * h);
  within(first.v_n_minus, slope, 1e-12L, "h⁴ truncation; rounding 1e-19/1e-6");
  within(first.t, 4.42296e-3L, 5e-9L, "published value, half its last digit");
  within(first.v_n_minus, -0.112919L, 5e-7L, "published value, half its last digit");
  within(first.impulse_n, 0.16700L, 5e-6L, "published value, half its last digit");
}

TEST_CASE("delivered restitution and duration of an impact: published values", "[references]") {
  for (std::size_t i = 0; i < delivered_table_e.size(); ++i) {
    for (const DampingLaw& law : delivered_table) {
      INFO(law.name << ", e = " << delivered_table_e[i]);
      within(delivered_restitution(law.chi(delivered_table_e[i])), law.delivered[i], 0.501 * law.digit,
             "half the last digit kept");
    }
    within(exact_chi(delivered_table_e[i]), exact_chi_table[i], 0.501e-5L, "half the last digit kept");
  }
  within(impact_duration_constant(1.5), 2.9432, 1e-4, "the published constant is cut off after four digits");
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

TEST_CASE("seven-body mechanism: the published positions close the loops", "[references]") {
  for (const auto& angles : {seven_body_start, seven_body_end}) {
    const auto p = seven_body_points(angles);
    for (int chain = 1; chain < 4; ++chain)
      within(std::abs(p[0] - p[chain]), 0, 1e-14, "15 digits of links below 0.07 m");
  }
}
