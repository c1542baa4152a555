// Growth of the differences that errors of impacts cause, in closed form, and the horizon of compare that
// follows from them.
#include "analysis/growth.hpp"

#include "study/comparison/compare.hpp"
#include "verification/support/rig.hpp"
#include "verification/unit/analysis/orbit_maps.hpp"

using namespace freeplay;
using verification::maps::event_driven, verification::maps::wall;

namespace {

constexpr double first_speed = 0.5, wall_distance = 0.2, wall_restitution = 0.8;

/// A point on a rail between two walls.
std::string ball_between_walls(double duration) {
  return test::body("ball", 1, 0.01, fmt::format("velocity = [{}, 0]\n", first_speed)) +
         test::guide("rail", "ground", "ball") + wall("left", "ground", "ball", 0, {0, 0}, {0, -1}) +
         "stiffness = 1e8\n" + wall("right", "ground", "ball", 0, {wall_distance, 0}, {0, 1}) +
         "stiffness = 1e8\n" + test::surface("s", wall_restitution) + test::run_for(duration) + event_driven;
}

/// A disc in a square with a round post: chaotic.
std::string chaotic_billiard(double slope) {
  return test::body("disc", 1, 1e-3, fmt::format("position = [0.07, 0.01]\nvelocity = [{}, 0.8]\n", slope)) +
         test::discs("post", "ground", "disc", 0.03, 0.01) +
         wall("left", "ground", "disc", 0.01, {-0.1, 0}, {0, -1}) +
         wall("right", "ground", "disc", 0.01, {0.1, 0}, {0, 1}) +
         wall("low", "ground", "disc", 0.01, {0, -0.1}, {1, 0}) +
         wall("high", "ground", "disc", 0.01, {0, 0.1}, {-1, 0}) +
         test::surface("s", 0.95, "young = 2e11\npoisson = 0.3\n") +
         "[penalty]\ncontact = \"exact\"\n[nonsmooth]\nscheme = \"event-driven\"\n" + test::run_for(3);
}

}  // namespace

TEST_CASE("differences between two walls grow as in closed form", "[growth]") {
  // An impact that is late by δ ends beyond the wall by u δ, and the ball returns with e u: the next onset
  // is late by δ (1 + 1/e) more. An impulse too great by ε changes the speed e u by (1 + e) u ε, that is,
  // relatively by (1 + e) ε/e, and the approach rate of the next impact likewise.
  const double delay = 1e-5, excess = 1e-6, e = wall_restitution;
  const auto scene = parse_scene(ball_between_walls(3), "walls");
  const auto found = growth_of_impact_errors(scene, {.errors = {{{delay, excess}}, {{delay, excess}}},
                                                     .restitution = {e, e},
                                                     .end = 3,
                                                     .most_evaluations = 1'000'000});
  CHECK(found.ended.empty());
  REQUIRE(found.onsets.size() >= 4);
  double change = 0, share = 0, t = wall_distance / first_speed, u = first_speed;
  for (const auto& o : found.onsets) {
    CAPTURE(o.t, o.t_change);
    CHECK(std::abs(o.t - t) < 1e-12);
    CHECK(std::abs(o.t_change - change) < 1e-8 * (delay + std::abs(change)));
    CHECK(std::abs(o.rate_change + share * u) < 1e-8 * (excess + share) * u);
    share += (1 + e) / e * excess;
    u *= e;
    t += wall_distance / u;
    change += delay * (1 + 1 / e) - share * wall_distance / u;
  }
}

TEST_CASE("compare's horizon in a chaotic billiard is predicted", "[growth][compare]") {
  for (const double slope : {0.35, 0.5, 0.62}) {
    test::TemporaryFolder folder;
    const auto found = compare(parse_scene(chaotic_billiard(slope), "billiard"), {}, folder.path() / "out");
    CAPTURE(slope, found.pairing.horizon, found.predicted.t, found.predicted.reason, found.pairing.ended_by);
    CHECK(found.predicted.reason.empty());
    REQUIRE(found.pairing.pairs.size() >= 4);
    CHECK_FALSE(found.pairing.complete);
    // Differences grow by factors of 2 to 10 at the post, once in about 0.25 s. Where they end the pairing,
    // the first order is no longer exact: two such times.
    CHECK(std::abs(found.predicted.t - found.pairing.horizon) < 0.5);
  }
}
