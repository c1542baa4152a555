// Periodic motions of time stepping and of the automatic scheme, and motions up to a shift.
#include "analysis/orbit.hpp"
#include "verification/support/rig.hpp"
#include "verification/unit/analysis/orbit_maps.hpp"

using namespace freeplay;
using namespace verification::maps;
using Catch::Matchers::Contains;

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

TEST_CASE("multipliers of time stepping equal those of differenced return maps", "[orbit]") {
  int compared[2] = {};
  double worst[2] = {};
  for (int i = 0; i < 10; ++i) {
    Draw draw(20261128, i);
    const auto m = random_map(i, draw);
    const auto by = [&](const char* option) {
      return parse_scene(m.text, "random", {"nonsmooth.scheme=moreau-jean", option});
    };
    const auto scene = by("nonsmooth.step_tolerance=1e-6");
    const auto adaptive = orbit(scene, {.settle = 20}),
               fixed = orbit(by("nonsmooth.step=2e-4"), {.settle = 20});
    CAPTURE(i, m.text, adaptive.failure, fixed.failure);
    if (!adaptive.failure.empty()) continue;
    // Displacements are far above the jumps of the map of adaptive steps, which the fit smooths. The jumps of
    // fixed steps are not: their multipliers are compared with the same derivatives.
    const auto fit = fitted(scene, m, adaptive, 1e-3, 24);
    for (const auto* found : {&adaptive, &fixed}) {
      // A journal that is off its bearing at the section has other coordinates than those differenced.
      if (!found->failure.empty() || found->multipliers.size() != m.own(adaptive.state).size()) continue;
      const bool is_fixed = found == &fixed;
      CAPTURE(is_fixed);
      // Beside the error of the fit: terms of fifth order over the displacements; an error of 2e-4 s of fixed
      // steps over changes of the motion within some hundredths of a second.
      const double error = apart(found->multipliers, fit.D);
      CHECK(error < spread(found->multipliers, fit) + (is_fixed ? 1e-2 : 1e-4));
      worst[is_fixed] = std::max(worst[is_fixed], error);
      ++compared[is_fixed];
    }
  }
  WARN(fmt::format("{} motions of adaptive and {} of fixed steps compared, greatest errors {:.2g} and {:.2g}",
                   compared[0], compared[1], worst[0], worst[1]));
  for (const int count : compared) CHECK(count >= 8);
}

TEST_CASE("a shift that is no symmetry of the mechanism is refused", "[orbit]") {
  const auto scene = read_scene(test::published("woodpecker"));
  const auto refused = [&](const std::vector<std::string>& shift, const char* reason) {
    CHECK_THROWS_WITH(orbit(scene, {.settle = 1, .period = 0.13, .shift = shift}), Contains(reason));
  };
  refused({"height"}, "\"height\" is not a coordinate");
  refused({"sleeve.y"}, "the constraint of spring changes");
  refused({"x"}, "the constraint of centre changes");
  refused({"sleeve.y", "bird.y", "bird.theta"}, "changes if the coordinates");
}
