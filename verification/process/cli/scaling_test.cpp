// The cost of large mechanisms, in counts. A contact problem close to that of the step before is
// solved in one or two steps of Newton's method, for any number of contacts. `freeplay scaling`
// measures the times.
#include "verification/timing/scaling.hpp"

#include <catch2/catch.hpp>

#include <algorithm>

using namespace freeplay;

TEST_CASE("a problem of many contacts takes no more pivots than one of few", "[islands][scaling]") {
  const auto growths = verification::growths();
  for (const char* name : {"row", "chain"}) {
    const auto& growth = *std::ranges::find(growths, name, &verification::Growth::name);
    for (const int count : {32, 256}) {
      const auto cost = verification::measure(growth, count, 1);
      CAPTURE(name, count);
      CHECK(cost.ending.empty());
      CHECK(cost.units >= 500);
      CHECK(cost.solves <= 1.1);  // per step
      CHECK(cost.pivots <= 4);    // one to confirm an unchanged solution, another after a change
    }
  }
}
