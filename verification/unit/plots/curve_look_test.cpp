// Looks of many curves: none repeats within a figure, with or without colours.
#include "plots/drawing/curve_look.hpp"

#include <set>
#include <utility>

#include "verification/support/rig.hpp"

using namespace freeplay;
using Text = std::string;

TEST_CASE("further curves repeat neither colour with mark nor mark with dashes", "[figures]") {
  // Nine colours times nine marks; in monochrome, nine marks times three dash patterns, each once for either
  // formulation.
  std::set<std::pair<std::size_t, Text>> coloured;
  for (std::size_t n = 0; n < 81; ++n) {
    const auto look = plots::curve_look(n, false);
    CHECK(look.colour == n % 9 + 1);
    CHECK(Text(look.mark.text()) == plots::curve_look(n, true).mark.text());
    coloured.insert({look.colour, look.mark.text()});
  }
  CHECK(coloured.size() == 81);
  std::set<std::pair<Text, Text>> black;
  for (std::size_t n = 0; n < 27; ++n)
    for (const bool broken : {false, true}) {
      const auto look = plots::curve_look(n, broken);
      black.insert({look.mark.text(), look.dash.text()});
    }
  CHECK(black.size() == 54);
}
