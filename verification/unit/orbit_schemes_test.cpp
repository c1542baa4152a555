// Periodic motions of time stepping and of the automatic scheme, and motions up to a shift.
#include <catch2/catch.hpp>
#include <cmath>
#include <string>
#include <vector>

#include "facade/orbit.hpp"
#include "mechanism/scene.hpp"
#include "verification/support/support.hpp"
#include "verification/support/texts.hpp"
#include "verification/unit/orbit_maps.hpp"

using namespace freeplay;
using namespace verification::maps;
using Catch::Matchers::Contains;

namespace {

std::string shift_refusal(const char* scene, const std::vector<std::string>& shift) {
  return test::refusal_of<std::exception>(
      [&] { orbit(read_scene(test::published(scene)), {.settle = 1, .period = 0.13, .shift = shift}); });
}

}  // namespace

TEST_CASE("a motion of time stepping has the error of its steps", "[orbit]") {
  Draw draw(20261126, 2);
  const auto m = two_masses(draw);
  const auto by = [&](const std::vector<std::string>& options) {
    return orbit(parse_scene(m.text, "masses", options), {.settle = 20});
  };
  const auto events = by({}), automatic = by({"nonsmooth.scheme=automatic"}),
             adaptive = by({"nonsmooth.scheme=moreau-jean"});
  REQUIRE(events.failure.empty());
  CHECK(events.step_error == 0);
  // Without a change of the scheme, automatic has the same digits.
  CHECK(automatic.state.q == events.state.q);
  CHECK(automatic.multipliers == events.multipliers);
  REQUIRE(adaptive.failure.empty());
  CHECK(adaptive.step_error > 0);
  CHECK(adaptive.residual <= 2 * adaptive.step_error);
  REQUIRE(adaptive.multipliers.size() == events.multipliers.size());
  // Steps of a tolerance of 1e-6, over the impacts of a period.
  for (std::size_t i = 0; i < events.multipliers.size(); ++i)
    CHECK(std::abs(adaptive.multipliers[i] - events.multipliers[i]) < 1e-3);
}

TEST_CASE("a shift that is no symmetry of the mechanism is refused", "[orbit]") {
  CHECK_THAT(shift_refusal("woodpecker", {"height"}), Contains("\"height\" is not a coordinate"));
  CHECK_THAT(shift_refusal("woodpecker", {"sleeve.y"}), Contains("the constraint of spring changes"));
  CHECK_THAT(shift_refusal("woodpecker", {"x"}), Contains("the constraint of centre changes"));
  CHECK_THAT(shift_refusal("woodpecker", {"sleeve.y", "bird.y", "bird.theta"}),
             Contains("changes if the coordinates"));
}
