#include "formulations/penalty/contact_law.hpp"

#include <fmt/format.h>

#include <boost/math/tools/toms748_solve.hpp>
#include <cmath>

namespace freeplay {
namespace {

template <class F>
double root(F f, double lo, double hi) {
  std::uintmax_t iterations = 200;
  const auto [a, b] =
      boost::math::tools::toms748_solve(f, lo, hi, boost::math::tools::eps_tolerance<double>(52), iterations);
  return 0.5 * (a + b);
}

}  // namespace

const char* name_of(ContactLaw law) {
  switch (law) {
    case ContactLaw::lankarani_nikravesh:
      return "lankarani-nikravesh";
    case ContactLaw::flores:
      return "flores";
    default:
      return "exact";
  }
}

double delivered_restitution(double chi) {
  if (chi == 0) return 1;
  // With y = ln(1 − χê): (1 − e^y) + χ + y = ln(1 + χ), monotone in y < 0, well conditioned for any χ.
  const double log_chi = std::log1p(chi);
  const auto f = [&](double y) { return chi - std::expm1(y) + y - log_chi; };
  // f < 0 at y = ln(1 + χ) − χ − 2 and f > 0 at 0; near χ = 0 the root tends to −χ.
  const double y = root(f, log_chi - chi - 2, 0);
  return -std::expm1(y) / chi;
}

double exact_damping_factor(double e) {
  if (e >= 1) return 0;
  // With y = ln(1 − χe), χ = (1 − e^y)/e: the trivial root y = 0 is divided out by bracketing away from it.
  const auto f = [&](double y) {
    const double chi = -std::expm1(y) / e;
    return chi * (1 + e) - std::log1p(chi) + y;
  };
  // Near y = 0, χ ≈ −y/e and f ≈ χ²(1 − e²)/2 > 0; far below, y dominates and f < 0.
  double near = -e * (1 - e);
  while (f(near) <= 0) near *= 0.5;
  double far = -(1 + 1 / e) * 2;
  while (f(far) >= 0) far *= 2;
  return -std::expm1(root(f, far, near)) / e;
}

double damping_factor(ContactLaw law, double e) {
  const auto needs_positive = [&] {
    if (e > 0) return;
    throw SceneError(
        fmt::format("penalty.contact = \"{}\" needs a restitution greater than 0: its damping factor is "
                    "infinite at 0",
                    name_of(law)));
  };
  switch (law) {
    case ContactLaw::lankarani_nikravesh:
      return 0.75 * (1 - e * e);
    case ContactLaw::flores:
      needs_positive();
      return 8 * (1 - e) / (5 * e);
    default:
      needs_positive();
      return exact_damping_factor(e);
  }
}

double hertz_stiffness(double young, double poisson, double radius_bearing, double radius_journal) {
  const double modulus = young / (2 * (1 - poisson * poisson));
  return 4.0 / 3.0 * modulus * std::sqrt(radius_bearing * radius_journal / (radius_bearing - radius_journal));
}

double hertz_duration(double stiffness, double mass, double speed) {
  const double depth = std::pow(5 * mass * speed * speed / (4 * stiffness), 0.4);
  return 2.9432750 * depth / speed;  // 2.9432… = (4/5) √π Γ(2/5)/Γ(9/10)
}

}  // namespace freeplay
