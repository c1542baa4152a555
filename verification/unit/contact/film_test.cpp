// The film's closed forms against quadrature of the pressure, and its limits. Quadrature: composite
// Simpson with 20,000 intervals; the integrand's fourth derivative grows like (1 − ε)^(−7), so at
// ε = 0.95 the error is still below 1e-8.
#include <catch2/catch.hpp>
#include <cmath>

#include "formulations/contact/film.hpp"
#include "formulations/contact/steady_film.hpp"
#include "verification/references/journal_bearing.hpp"

using namespace freeplay;

namespace {

constexpr double pi = 3.14159265358979323846;

Film film(Film::Kind kind, bool cavitated) { return {kind, cavitated, 0.04, 0.02, 0.01, 0.2e-3}; }

/// Pressure per unit of length (short) or pressure (long) by integrating Reynolds' equation from
/// its definition.
double pressure(const Film& f, double e, double w_r, double w_t, double t) {
  const double c3 = std::pow(f.clearance, 3), x = 1 - e * std::cos(t);
  if (f.kind == Film::Kind::short_bearing)
    return f.viscosity * std::pow(f.length, 3) / c3 * (w_r * std::cos(t) + w_t * std::sin(t)) / (x * x * x);
  return 12 * f.viscosity * f.radius * f.radius / c3 *
         (w_r / (2 * e) * (1 / (x * x) - 1 / ((1 + e) * (1 + e))) +
          w_t * std::sin(t) * (2 - e * std::cos(t)) / ((2 + e * e) * x * x));
}

Film::Force<double> by_quadrature(const Film& f, double e, double w_r, double w_t) {
  const int n = 20000;
  double r = 0, s = 0;
  for (int i = 0; i <= n; ++i) {
    const double t = -pi + 2 * pi * i / n, weight = (i == 0 || i == n) ? 1 : i % 2 ? 4 : 2;
    double p = pressure(f, e, w_r, w_t, t);
    if (f.cavitated) p = std::max(0.0, p);
    r += weight * p * std::cos(t);
    s += weight * p * std::sin(t);
  }
  const double scale = -f.radius * (2 * pi / n) / 3 * (f.kind == Film::Kind::long_bearing ? f.length : 1);
  return {scale * r, scale * s};
}

}  // namespace

TEST_CASE("film forces equal the quadrature of their pressure at small and large eccentricity", "[film]") {
  for (auto kind : {Film::Kind::short_bearing, Film::Kind::long_bearing})
    for (bool cavitated : {false, true})
      for (double e : {1e-3, 0.05, 0.3, 0.6, 0.9, 0.95})
        for (double angle : {0.0, 0.4, 1.5707963, 2.0, 3.0, -0.7, -1.5707963, -2.6}) {
          const auto f = film(kind, cavitated);
          const double w_r = 0.1 * std::cos(angle), w_t = 0.1 * std::sin(angle);
          const auto exact = by_quadrature(f, e, w_r, w_t), closed = f.force(e, w_r, w_t);
          const double size = std::hypot(exact.radial, exact.tangential);
          CAPTURE(static_cast<int>(kind), cavitated, e, angle);
          // At e = 1e-3 the long bearing's primitives cancel to ε² = 1e-6 of their size: ten digits
          // remain. The kink at the edge of a cavitated film causes an error of Simpson's rule of
          // (2π/20000)² ≈ 1e-7.
          CHECK(closed.radial == Approx(exact.radial).margin(2e-7 * size));
          CHECK(closed.tangential == Approx(exact.tangential).margin(2e-7 * size));
          CHECK(closed.radial * w_r + closed.tangential * w_t <= 0);
        }
}

// Steady running of a lubricated joint: limits of the load. Closed forms of the coefficients are in
// verification/claims/film_coefficients.cpp.

TEST_CASE("a film carries loads up to that at its hand-over thickness", "[film]") {
  // The gudgeon pin of cases/lubricated-pin.
  constexpr reference::JournalBearing pin{true, true, 0.2, 11.125e-3, 20e-3, 0.25e-3};
  const Film film{Film::Kind::short_bearing, true, pin.viscosity, pin.length, pin.radius, pin.clearance,
                  0.01 * pin.clearance};
  const double omega = 20, most = pin.capacity(0.99, omega);
  // Rounding, times d ln ε/d ln W < 1.
  CHECK(steady_ratio(film, most * (1 - 1e-9), omega).value() == Approx(0.99).epsilon(1e-8));
  CHECK_FALSE(steady_ratio(film, most * (1 + 1e-9), omega));
  // Near the centre W = π μωRL³ε/(4c²); the next order is ε².
  const double unit =
      pin.viscosity * omega * pin.radius * std::pow(pin.length, 3) / std::pow(pin.clearance, 2);
  CHECK(steady_ratio(film, 3.141592653589793 / 4 * unit * 1e-5, omega).value() == Approx(1e-5).epsilon(1e-8));
}
