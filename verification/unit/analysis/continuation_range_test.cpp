// Ends of the range of a continuation, its restart there, events of the user and crossings of branches.
#include "analysis/continuation.hpp"
#include "analysis/orbit.hpp"
#include "verification/claims/orbit_scenes.hpp"
#include "verification/references/orbits.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;

namespace {

std::size_t count_of(const Branches& found, BifurcationKind kind) {
  return static_cast<std::size_t>(std::ranges::count(found.bifurcations, kind, &Bifurcation::kind));
}

/// A loaded table whose contact opens at the amplitude `liftoff`.
const reference::LoadedTable table{60, 9.81L, 0.3L};
const double liftoff = static_cast<double>(table.liftoff()),
             weight = static_cast<double>(table.gravity * table.mass);
Scene loaded_table(long double share) {
  return parse_scene(verification::scenes::loaded_table(table, share * table.liftoff()), "table");
}

}  // namespace

TEST_CASE("a branch ends at the ends of its range also if a step lands there", "[orbit]") {
  // The forced motion of a loaded table depends linearly on its amplitude, so that steps land where
  // they aim: the first step is half of the greatest one.
  const auto found = continue_orbit(loaded_table(0.5L), {.key = "curves.shake.amplitude",
                                                         .from = 0.4 * liftoff,
                                                         .to = 0.6 * liftoff,
                                                         .start = 0.5 * liftoff,
                                                         .step = 0.2 * liftoff,
                                                         .settle = 0});
  REQUIRE(found.failure.empty());
  REQUIRE(found.ends.size() == 2);
  for (const auto& end : found.ends) CHECK(end.reason == "the range of the key ends");
  const auto [least, greatest] =
      std::ranges::minmax(found.points, {}, [](const BranchPoint& p) { return p.parameter; });
  CHECK(least.parameter == Approx(0.4 * liftoff).epsilon(1e-12));
  CHECK(greatest.parameter == Approx(0.6 * liftoff).epsilon(1e-12));
  CHECK(found.bifurcations.empty());
}

TEST_CASE("a branch goes on from the last motion of an earlier one", "[orbit]") {
  const auto scene = loaded_table(0.5L);
  const ContinuationRequest first{.key = "curves.shake.amplitude",
                                  .from = 0.5 * liftoff,
                                  .to = 0.6 * liftoff,
                                  .step = 0.02 * liftoff,
                                  .settle = 0};
  const auto short_one = continue_orbit(scene, first);
  REQUIRE(short_one.failure.empty());
  auto longer = first;
  longer.to = 0.8 * liftoff;
  longer.restarts = {{short_one.points.back(), true, "start"}};
  longer.branches = 1;
  const auto found = continue_orbit(scene, longer);
  REQUIRE(found.failure.empty());
  REQUIRE(found.ends.size() == 1);
  CHECK(found.ends[0].branch == 1);
  CHECK(found.points.front().number == short_one.points.back().number + 1);
  CHECK(found.points.front().parameter > 0.6 * liftoff);
  CHECK(found.points.back().parameter == Approx(0.8 * liftoff).epsilon(1e-12));
  CHECK(found.ends[0].points == found.points.back().number + 1);
  // The least force of the table's contact decreases linearly from the weight to 0 at the lift-off.
  for (const auto& p : found.points)
    CHECK(p.orbit.lasting.at(0).least_force == Approx(weight * (1 - p.parameter / liftoff)).epsilon(1e-8));
  auto same = first;
  same.restarts = longer.restarts;
  CHECK_THAT(continue_orbit(scene, same).failure, Catch::Matchers::Contains("give a longer range"));
}

TEST_CASE("zeros of a quantity of the user are located on a branch", "[orbit]") {
  const auto found = continue_orbit(
      loaded_table(0.3L),
      {.key = "curves.shake.amplitude",
       .from = 0.3 * liftoff,
       .to = 0.9 * liftoff,
       .settle = 0,
       .events = {{"least_force - 0.55 weight",
                   [&](const BranchPoint& p) { return p.orbit.lasting.at(0).least_force - 0.55 * weight; }},
                  {"a jump", [&](const BranchPoint& p) { return p.parameter < 0.5 * liftoff ? -1.0 : 1.0; }},
                  {"nothing", [](const BranchPoint&) { return NAN; }}}});
  REQUIRE(found.failure.empty());
  REQUIRE(found.bifurcations.size() == 1);  // not at the jump
  CHECK(found.bifurcations[0].kind == BifurcationKind::event);
  CHECK(found.bifurcations[0].follows == "least_force - 0.55 weight");
  CHECK(found.bifurcations[0].at.parameter == Approx(0.45 * liftoff).epsilon(1e-9));
}

TEST_CASE("branches that cross at a multiplier 1 are followed to both sides", "[orbit]") {
  // An inverted pendulum on a torsion spring, beside a rotor that gives a period: upright, it
  // buckles where the rate k of the spring is m g l, into k θ = m g l sin θ.
  const double weight = 2 * 9.81 * 0.5;
  const auto text = "gravity = [0, -9.81]\n" + test::body("rotor", 1, 0.01, "angular_velocity = 6.0\n") +
                    test::pin("axle", "ground", "rotor") + test::motor("motor", "axle", 6.0) +
                    test::body("rod", 2, 0.3, "position = [0, 0.5]\n") +
                    test::pin("hinge", "ground", "rod", {}, {0, -0.5}) +
                    test::torsion("spring", "ground", "rod", 1.3 * weight, "damping = 0.8\n") +
                    test::run_for(1, "start = \"given\"\n[nonsmooth]\nscheme = \"event-driven\"\n");
  const auto found = continue_orbit(
      parse_scene(text, "s.toml"),
      {.key = "loads.spring.stiffness", .from = 1.3 * weight, .to = 0.7 * weight, .settle = 0});
  REQUIRE(found.failure.empty());
  REQUIRE(count_of(found, BifurcationKind::crossing) == 1);
  const auto crossing = std::ranges::find(found.bifurcations, BifurcationKind::crossing, &Bifurcation::kind);
  CHECK(crossing->at.parameter == Approx(weight).epsilon(1e-8));
  CHECK(crossing->new_branch == 2);
  REQUIRE(found.ends.size() == 3);
  double least = 0, greatest = 0;
  for (const auto& p : found.points) {
    const double angle = p.orbit.state.q[5];
    CHECK(p.parameter * angle == Approx(weight * std::sin(angle)).margin(1e-7 * weight));
    if (p.branch == 1) CHECK(p.orbit.stable == (p.parameter > weight));
    if (p.branch > 1) CHECK(p.orbit.stable);
    least = std::min(least, angle);
    greatest = std::max(greatest, angle);
  }
  // θ/sin θ = 1/0.7 at the end of the range
  CHECK(greatest == Approx(1.4101853766).margin(1e-6));
  CHECK(least == Approx(-greatest).epsilon(1e-6));
}

TEST_CASE("branches are followed at a tolerance whose residuals are near rounding", "[orbit]") {
  // A ball on a shaken table: the motion of doubled period after the flip, far into its unstable part.
  const reference::ShakenBall ball{0.0125L, 30.79L, 9.81L, 0.65L};
  const auto found = continue_orbit(
      parse_scene(verification::scenes::shaken_ball(ball, 0), "ball", {"nonsmooth.tolerance=1e-12"}),
      {.key = "curves.shake.amplitude", .from = 0.0125, .to = 0.02, .settle = 0, .most_points = 150});
  REQUIRE(found.failure.empty());
  REQUIRE(count_of(found, BifurcationKind::flip) >= 1);
  const auto flip = std::ranges::find(found.bifurcations, BifurcationKind::flip, &Bifurcation::kind);
  CHECK(flip->at.parameter == Approx(static_cast<double>(ball.flip())).epsilon(1e-8));
  for (const auto& end : found.ends) CHECK(end.reason == "the range of the key ends");

  // The branch behind a grazing impact
  const reference::ImpactOscillator o{0.5L, 1, 200, 6, 30, 0.02L, 0.7L};
  long double impact = 0;
  const auto grazes = continue_orbit(
      parse_scene(verification::scenes::impact_oscillator(o, impact), "o", {"nonsmooth.tolerance=1e-12"}),
      {.key = "curves.force.amplitude", .from = 6, .to = 0.5, .settle = 0, .most_points = 300});
  REQUIRE(grazes.failure.empty());
  const auto grazing = std::ranges::find(grazes.bifurcations, BifurcationKind::grazing, &Bifurcation::kind);
  REQUIRE(grazing != grazes.bifurcations.end());
  CHECK(grazing->at.parameter == Approx(static_cast<double>(o.grazing())).epsilon(1e-7));
  CHECK(grazing->new_branch > 0);
  CHECK(grazes.ends.back().reason == "the range of the key ends");
}

TEST_CASE("motions of the penalty formulation are followed", "[orbit][penalty]") {
  // A stable motion of a ball on a soft shaken table: those of the branch are the ones that runs settle to.
  const reference::ShakenBall ball{3.3e-3L, 60, 9.81L, 0.5L};
  const auto scene = parse_scene(verification::scenes::shaken_ball(ball, 0), "ball",
                                 {"surfaces.hard.young=2e8", "surfaces.hard.poisson=0.3"});
  const auto found = continue_orbit(scene, {.formulation = "penalty",
                                            .key = "curves.shake.amplitude",
                                            .from = 3.3e-3,
                                            .to = 3.6e-3,
                                            .step = 0.1e-3,
                                            .settle = 30.3});
  REQUIRE(found.failure.empty());
  REQUIRE(found.ends.size() == 1);
  CHECK(found.ends[0].reason == "the range of the key ends");
  const auto& last = found.points.back();
  REQUIRE(last.parameter == Approx(3.6e-3));
  auto there = scene;
  there.set("curves.shake.amplitude", 3.6e-3);
  const auto settled = orbit(there, {.formulation = "penalty", .settle = 40.3});
  REQUIRE(settled.failure.empty());
  REQUIRE(settled.impacts.size() == last.orbit.impacts.size());
  CHECK(last.orbit.impacts[0].speed == Approx(settled.impacts[0].speed).epsilon(1e-6));
  REQUIRE(settled.multipliers.size() == last.orbit.multipliers.size());
  const auto of = [](const Orbit& o) { return o.multipliers[0] + o.multipliers[1]; };
  CHECK(of(last.orbit).real() == Approx(of(settled).real()).epsilon(1e-4));
  // Nearly that of rigid bodies
  CHECK(last.orbit.impacts[0].speed == Approx(static_cast<double>(ball.approach())).epsilon(0.02));
}
