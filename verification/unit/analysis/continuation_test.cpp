// Continuation of periodic motions: refusals, ends of branches, and the order of what is reported.
#include "analysis/continuation.hpp"
#include "verification/claims/orbit_scenes.hpp"
#include "verification/references/orbits.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;
using Catch::Matchers::Contains;

namespace {

const reference::ShakenBall table_ball{0.0032L, 20 * reference::ShakenBall::pi(), 9.81L, 0.5L};

Scene table_scene(const std::vector<std::string>& options = {}) {
  return parse_scene(verification::scenes::shaken_ball(table_ball, 1e-4L), "s.toml", options);
}

}  // namespace

TEST_CASE("requests of branches that cannot be followed are refused", "[orbit]") {
  const auto scene = table_scene();
  const auto refused = [](const Scene& of, const ContinuationRequest& request, const char* reason) {
    CHECK_THROWS_WITH(continue_orbit(of, request), Contains(reason));
  };
  const std::string key = "curves.shake.amplitude";
  refused(scene, {.key = "curves.shake.height", .from = 1, .to = 2}, "curves.shake.height");
  refused(scene, {.key = key, .from = 1e-3, .to = 1e-3}, "must differ from");
  refused(scene, {.key = key, .from = 3e-3, .to = 4e-3, .step = -1.0}, "must be greater than 0");
  refused(table_scene({"nonsmooth.scheme=moreau-jean", "nonsmooth.step=1e-4"}),
          {.key = key, .from = 3e-3, .to = 4e-3}, "orbits of time stepping are not available");
  refused(scene, {.key = "nonsmooth.tolerance", .from = 1e-9, .to = 1e-8}, "numerical setting");
  ContinuationRequest curve{.key = key, .from = 3e-3, .to = 4e-3};
  curve.second = SecondKey{.key = "surfaces.hard.restitution", .from = 0.6, .to = 0.7};
  refused(scene, curve, "= 0.5 in the scene");
  curve.second = SecondKey{.key = key, .from = 1e-3, .to = 4e-3};
  refused(scene, curve, "must differ from continue.key");
}

TEST_CASE("a branch ends at both ends of the range and reports what it meets in order", "[orbit]") {
  // From a stable motion over the fold at 2.602 mm back to the start, which is met on the unstable side.
  std::vector<double> values;
  std::vector<std::size_t> folds;  // number of motions reported before each
  const auto scene = table_scene();
  const ContinuationRequest request{
      .key = "curves.shake.amplitude", .from = 2.7e-3, .to = 2.5e-3, .settle = 0};
  Continuation branches(scene, request);
  const auto& found = branches.found();
  while (branches.advance()) {
    if (found.bifurcations.size() > folds.size()) {
      CHECK(found.bifurcations.back().kind == BifurcationKind::fold);
      CHECK(found.bifurcations.back().at.number == static_cast<int>(values.size()));
      folds.push_back(values.size());
    }
    if (found.points.size() == values.size()) continue;
    CHECK(found.points.back().branch == 1);
    CHECK(found.points.back().number == static_cast<int>(values.size()));
    values.push_back(found.points.back().parameter);
  }
  REQUIRE(found.points.size() == values.size());
  CHECK(found.failure.empty());
  REQUIRE(folds.size() == 1);
  REQUIRE(values.size() > folds[0]);
  CHECK(values.front() == 2.7e-3);
  CHECK(std::abs(values.back() - 2.7e-3) < 1e-12);
  for (const double x : values) CHECK(x > static_cast<double>(table_ball.fold()) * (1 - 1e-9));
  for (std::size_t i = 1; i < folds[0]; ++i) CHECK(values[i] < values[i - 1]);
  for (std::size_t i = folds[0] + 1; i < values.size(); ++i) CHECK(values[i] > values[i - 1]);
  for (const auto& p : found.points) CHECK(p.orbit.stable == (p.number < static_cast<int>(folds[0])));
  REQUIRE(found.ends.size() == 1);
  CHECK_THAT(found.ends[0].reason, Contains("range of the key ends"));
}

TEST_CASE("a continuation without a first motion has its reason", "[orbit]") {
  const auto found =
      continue_orbit(table_scene({"bodies.ball.position=[0, 0.5]"}),
                     {.key = "curves.shake.amplitude", .from = 10e-3, .to = 9e-3, .settle = 0});
  CHECK_THAT(found.failure, Contains("curves.shake.amplitude = 0.01"));
  CHECK(found.points.empty());
}
