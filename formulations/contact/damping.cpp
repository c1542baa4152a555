// Damping factors χ(e) and the restitution that they deliver; contact_law.hpp has the equation.
#include <fmt/format.h>

#include <boost/math/tools/toms748_solve.hpp>
#include <cmath>

#include "formulations/contact/contact_law.hpp"
#include "generated/contact_laws.hpp"
#include "mechanism/error.hpp"

namespace freeplay {
namespace {

template <class F>
double root(F f, double lo, double hi) {
  std::uintmax_t iterations = 200;
  const auto [a, b] =
      boost::math::tools::toms748_solve(f, lo, hi, boost::math::tools::eps_tolerance<double>(52), iterations);
  return 0.5 * (a + b);
}

/// Near e = 1 the terms of the equation cancel. The series of the equation, divided by χ²,
///     (1 − e²)/2 − χ(1 + e³)/3 + χ²(1 − e⁴)/4 − χ³(1 + e⁵)/5 + χ⁴(1 − e⁶)/6 = 0,
/// is used there. For 1 − e or χ below 1e-3 the truncation error is 1e-15 of the leading term.
constexpr double series_below = 1e-3;
double series(double chi, double e) {
  const double e2 = e * e, e3 = e2 * e;
  return (1 - e) * (1 + e) / 2 -
         chi * ((1 + e3) / 3 - chi * ((1 - e) * (1 + e) * (1 + e2) / 4 -
                                      chi * ((1 + e3 * e2) / 5 - chi * (1 - e3) * (1 + e3) / 6)));
}
/// Newton's method with the series' leading derivatives: ∂/∂χ ≈ −(1 + e³)/3, ∂/∂e ≈ −e.
double chi_by_series(double e) {
  double chi = 1.5 * (1 - e) * (1 + e) / (1 + e * e * e);
  for (int i = 0; i < 6; ++i) chi += 3 * series(chi, e) / (1 + e * e * e);
  return chi;
}
double restitution_by_series(double chi) {
  double e = 1 - 2 * chi / 3;
  for (int i = 0; i < 12; ++i) e += series(chi, e) / e;
  return e;
}

}  // namespace

double delivered_restitution(double chi) {
  if (chi == 0) return 1;
  if (chi < series_below) return restitution_by_series(chi);
  // With y = ln(1 − χê) the equation is (1 − e^y) + χ + y = ln(1 + χ), monotone in y < 0 and well
  // conditioned for any χ.
  const double log_chi = std::log1p(chi);
  const auto f = [&](double y) { return chi - std::expm1(y) + y - log_chi; };
  // f < 0 at y = ln(1 + χ) − χ − 2 and f > 0 at 0; near χ = 0 the root tends to −χ.
  const double y = root(f, log_chi - chi - 2, 0);
  return -std::expm1(y) / chi;
}

double exact_damping_factor(double restitution) {
  const double e = restitution;
  if (e >= 1) return 0;
  if (1 - e < series_below) return chi_by_series(e);
  // With y = ln(1 − χe), χ = (1 − e^y)/e. The bracket excludes the trivial root y = 0.
  const auto f = [&](double y) {
    const double chi = -std::expm1(y) / e;
    return chi * (1 + e) - std::log1p(chi) + y;
  };
  // Near y = 0, χ ≈ −y/e and f ≈ χ²(1 − e²)/2 > 0; for large −y, y dominates and f < 0.
  double near = -e * (1 - e);
  while (f(near) <= 0) near *= 0.5;
  double far = -(1 + 1 / e) * 2;
  while (f(far) >= 0) far *= 2;
  return -std::expm1(root(f, far, near)) / e;
}

double damping_factor(ContactLaw law, double restitution) {
  const auto& facts = facts_of(law);
  if (facts.positive_restitution && !(restitution > 0))
    throw ModelError(
        "penalty.contact",
        fmt::format("\"{}\" needs a restitution greater than 0: its damping factor is infinite at 0",
                    facts.text));
  return visit_law(law, [&](auto l) -> double {
    if constexpr (l.kind == ContactKind::point) return l.chi(restitution);
    throw ModelError("penalty.damping", fmt::format("\"{}\" has no damping factor of its own", facts.text));
  });
}

/// m δ̈ + D δ̇ + K δ = 0 from δ = 0. With ζ = D/(2√(Km)) the force vanishes at ω_d
/// t = atan2(2ζ√(1−ζ²), 2ζ²−1), where the speed has decreased to e^(−ζ ω₀ t). The overdamped
/// solution has hyperbolic functions instead.
double kelvin_voigt_restitution(double stiffness, double viscous, double mass) {
  const double zeta = viscous / (2 * std::sqrt(stiffness * mass));
  if (zeta == 0) return 1;
  if (std::abs(zeta - 1) < 1e-9) return std::exp(-2);
  if (zeta < 1) {
    const double s = std::sqrt(1 - zeta * zeta);
    return std::exp(-zeta / s * std::atan2(2 * zeta * s, 2 * zeta * zeta - 1));
  }
  const double s = std::sqrt(zeta * zeta - 1);
  return std::exp(-zeta / s * std::log((zeta + s) / (zeta - s)));
}

}  // namespace freeplay
