// What large mechanisms cost, in counts: a problem that time knows already is met in a step or two of Newton's method
// however many contacts it has. The times are measured by freeplay scaling.
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
      CHECK(cost.solves <= 1.1);  // a step
      CHECK(cost.pivots <= 4);    // one to see that nothing has changed, another where something has
    }
  }
}
