// Penalty laws against the table of delivered restitutions, whose values come from the implicit equation
// solved by bisection (verification/references/delivered_restitution.hpp), and against direct integration of
// an impact.
#include "formulations/contact/contact_law.hpp"

#include <catch2/catch.hpp>

#include <cmath>

#include "formulations/contact/friction_law.hpp"
#include "mechanism/error.hpp"

using namespace freeplay;

TEST_CASE("laws deliver the tabulated restitution", "[laws]") {
  // Five printed digits: half a unit of the last.
  const double e[] = {0.1, 0.3, 0.46, 0.5, 0.7, 0.9};
  const double lankarani[] = {.66527, .68422, .71499, .72524, .79597, .91318};
  const double flores[] = {.06944, .25621, .42746, .47044, .68318, .89392};
  const double chi[] = {9.99816, 3.08708, 1.66351, 1.43275, .63483, .16648};
  for (int i = 0; i < 6; ++i) {
    CAPTURE(e[i]);
    REQUIRE(delivered_restitution(damping_factor(ContactLaw::lankarani_nikravesh, e[i])) ==
            Approx(lankarani[i]).margin(5e-6));
    REQUIRE(delivered_restitution(damping_factor(ContactLaw::flores, e[i])) ==
            Approx(flores[i]).margin(5e-6));
    REQUIRE(exact_damping_factor(e[i]) == Approx(chi[i]).margin(5e-6));
  }
}

TEST_CASE("the exact law delivers what it is asked for, near both ends as well", "[laws]") {
  for (double e : {1e-3, 0.01, 0.05, 0.2, 0.46, 0.8, 0.99, 0.9985, 0.999, 0.9995, 0.9999, 0.999999, 1 - 1e-11,
                   1 - 1e-15}) {
    CAPTURE(e);
    const double chi = exact_damping_factor(e);
    // Where χ → 0 the equation's root is conditioned like 1/χ: allow rounding over χ.
    REQUIRE(delivered_restitution(chi) == Approx(e).epsilon(1e-12 + 1e-15 / chi));
  }
  REQUIRE(exact_damping_factor(1) == 0);
  REQUIRE(delivered_restitution(0) == 1);
  REQUIRE_THROWS_AS(damping_factor(ContactLaw::exact, 0), ModelError);
  REQUIRE_THROWS_AS(damping_factor(ContactLaw::flores, 0), ModelError);
}

TEST_CASE("an impact integrated directly delivers the restitution of the implicit equation", "[laws]") {
  // m δ̈ = −F by classical Runge–Kutta with 20,000 steps over a contact: fourth order but for the start and
  // the end of δ^1.5, whose local error h^2.5 gives about (1/20000)^2.5 ≈ 2e-11; bound 1e-7 with the linear
  // end search.
  for (double chi : {0.2, 0.59, 1.66, 10.0}) {
    const ElasticLaw law{ElasticLaw::Kind::hertz, 1e9};
    const double m = 0.8, v0 = 0.3;
    const double h = elastic_duration(law, m, v0) / 20000;
    double d = 0, v = v0, t = 0;
    const auto a = [&](double x, double w) { return x > 0 ? -law.force(x) * (1 + chi * w / v0) / m : 0; };
    double d_old = 0, v_old = v0;
    while (d > 0 || t == 0) {
      d_old = d;
      v_old = v;
      const double k1 = a(d, v), k2 = a(d + h / 2 * v, v + h / 2 * k1),
                   k3 = a(d + h / 2 * v + h * h / 4 * k1, v + h / 2 * k2),
                   k4 = a(d + h * v + h * h / 2 * k2, v + h * k3);
      d += h * v + h * h / 6 * (k1 + k2 + k3);
      v += h / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
      t += h;
    }
    const double s = d_old / (d_old - d);
    REQUIRE(-(v_old + s * (v - v_old)) / v0 == Approx(delivered_restitution(chi)).margin(1e-7));
  }
}

TEST_CASE("stiffness is the one of the paper's equation (4)", "[laws]") {
  // Flores et al. 2011, equation (4) with E = 207 GPa, ν = 0.3, R_i = 11.125 mm: five printed digits.
  const double c[] = {0.10e-3, 0.25e-3, 0.50e-3, 1.00e-3};
  const double K[] = {1.6795e11, 1.0550e11, 7.373e10, 5.090e10};
  for (int i = 0; i < 4; ++i)
    REQUIRE(hertz_stiffness(207e9, 0.3, 11.125e-3 * (11.125e-3 - c[i]) / c[i]) == Approx(K[i]).epsilon(1e-4));
}

TEST_CASE("regularised friction", "[laws]") {
  REQUIRE(preloaded_friction(10, 1e-3, 5e-4) == Approx(-5));
  REQUIRE(preloaded_friction(10, 1e-3, -1.0) == 10);
}
