// References of impacts (laws of restitution, elastic and oblique impacts), compared with facts that
// none of them is computed from. Units are SI throughout.
#include <algorithm>
#include <boost/math/quadrature/tanh_sinh.hpp>
#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "verification/references/delivered_restitution.hpp"
#include "verification/references/hertz_impact.hpp"
#include "verification/references/oblique_impact.hpp"
#include "verification/unit/references/reference_checks.hpp"

using namespace freeplay::reference;

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
  CHECK(oblique_impact(d, 0.1, 1.0, 0.5, 0.3).kind == ImpactCase::none);
  CHECK_THROWS(oblique_impact(Delassus<double>{1, 3, 20}, -1.0, 0.0, 0.5, 0.5));
}
