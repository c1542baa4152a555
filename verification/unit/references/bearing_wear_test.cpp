// References of wear: the area of a lune in two ways, published digits, and limits by hand.
#include <catch2/catch.hpp>
#include <cmath>

#include "verification/references/bearing_wear.hpp"

using namespace freeplay::reference;

TEST_CASE("reference of wear: the lune by segments, by its chord and by its area", "[references]") {
  const BoreAndJournal bore{10e-3, 0.5e-3, 20e-3};
  struct Row {
    double depth, sliding, half_angle;  // m, m, °
  };
  // Computed by another program, for 100 N and 1e-15 m²/N, rounded to the digits shown.
  for (const auto& row : {Row{1e-6, 164.2365, 3.528887}, Row{10e-6, 5152.095615, 11.073276},
                          Row{100e-6, 151334.481650, 32.594937}}) {
    CAPTURE(row.depth);
    const double area = lune_area_by_chord(bore, row.depth);
    // Segments cancel from r² = 1e-4 m² with rounding of 1e-16.
    CHECK(std::abs(lune_area(bore, row.depth) - area) < 1e-19);
    CHECK(lune_depth(bore, area) == Approx(row.depth).epsilon(1e-12));
    CHECK(sliding_to(bore, area, 100, 1e-15) == Approx(row.sliding).epsilon(1e-9));
    CHECK(std::abs(lune_half_angle(bore, row.depth) * 180 / std::acos(-1.0) - row.half_angle) < 1e-6);
  }
}

TEST_CASE("reference of wear: even wear and narrow contacts", "[references]") {
  const double pi = std::acos(-1.0), R = 10e-3, h = 100e-6;
  CHECK(even_depth(R, pi * ((R + h) * (R + h) - R * R), 1) == Approx(h).epsilon(1e-12));
  CHECK(even_depth(R, pi * (R * R - (R - h) * (R - h)), -1) == Approx(h).epsilon(1e-12));
  // δ ≪ c ≪ R: the parabola δ − s²/(2 R_eff), F = (2/3) K L a³/R_eff with a² = 2 R_eff δ, R_eff = R r/c; the next
  // terms are of the order of δ/c and c/R.
  const BoreAndJournal narrow{10e-3, 1e-6, 20e-3};
  const double depth = 1e-9, effective = narrow.bore * narrow.journal() / narrow.clearance;
  CHECK(
      foundation_load(narrow, 1e12, depth) ==
      Approx(1e12 * narrow.length * 2 / 3 * std::pow(2 * effective * depth, 1.5) / effective).epsilon(2e-3));
}
