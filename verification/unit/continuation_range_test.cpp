// Ends of the range of a continuation.
#include <algorithm>
#include <catch2/catch.hpp>

#include "facade/continuation.hpp"
#include "mechanism/scene.hpp"
#include "verification/claims/orbit_scenes.hpp"
#include "verification/references/orbits.hpp"

using namespace freeplay;

TEST_CASE("a branch ends at the ends of its range also if a step lands there", "[orbit]") {
  // The forced motion of a loaded table depends linearly on its amplitude, so that steps land where they aim: the
  // first step is half of the greatest one.
  const reference::LoadedTable table{60, 9.81L, 0.3L};
  const auto unit = static_cast<double>(table.liftoff());
  const auto scene = parse_scene(verification::scenes::loaded_table(table, 0.5L * table.liftoff()), "table");
  const auto found = continue_orbit(scene, {.key = "curves.shake.amplitude",
                                            .from = 0.4 * unit,
                                            .to = 0.6 * unit,
                                            .start = 0.5 * unit,
                                            .step = 0.2 * unit,
                                            .settle = 0});
  REQUIRE(found.failure.empty());
  REQUIRE(found.ends.size() == 2);
  for (const auto& end : found.ends) CHECK(end.reason == "the range of the key ends");
  const auto [least, greatest] =
      std::ranges::minmax(found.points, {}, [](const BranchPoint& p) { return p.parameter; });
  CHECK(least.parameter == Approx(0.4 * unit).epsilon(1e-12));
  CHECK(greatest.parameter == Approx(0.6 * unit).epsilon(1e-12));
  CHECK(found.bifurcations.empty());
}
