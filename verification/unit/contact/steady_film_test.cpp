// Steady running of a lubricated joint: limits of the load. Closed forms of the coefficients are in
// verification/claims/film_coefficients.cpp.
#include "formulations/contact/steady_film.hpp"

#include <catch2/catch.hpp>

#include "verification/references/journal_bearing.hpp"

using namespace freeplay;

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
