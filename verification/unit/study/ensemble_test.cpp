// Ensembles: each start equals its single run, and bands are the quantiles of the runs.
#include "study/ensemble/ensemble.hpp"
#include "dynamics/system.hpp"
#include "io/files/output_file.hpp"
#include "io/scene/read_scene.hpp"
#include "simulation/trajectory.hpp"
#include "study/partition/divided.hpp"
#include "study/partition/merge.hpp"
#include "study/partition/shard.hpp"
#include "verification/support/rig.hpp"
#include "verification/support/study_desk.hpp"

using namespace freeplay;
using Catch::Matchers::Contains;

namespace {

std::shared_ptr<const Scene> rig() {
  return open_scene(test::flores(),
                    {"run.revolutions=0.2", "run.discard=0.05", "joints.gudgeon.clearance=0.5e-3"});
}

}  // namespace

TEST_CASE("quantiles, errors and confidence intervals of known values", "[study][ensemble]") {
  const auto s = spread({5, 1, NAN, 3, 2, 4});
  CHECK(s.of.count == 5);
  CHECK(s.of.mean == Approx(3));
  CHECK(s.error == Approx(std::sqrt(2.5 / 5)));
  // Student's t of 4 degrees of freedom
  CHECK(0.5 * (s.of.high - s.of.low) == Approx(2.7764451 * s.error));
  CHECK(s.quantile[0] == Approx(1.2));
  CHECK(s.quantile[2] == 3);
  CHECK(s.quantile[4] == Approx(4.8));
  CHECK(std::isnan(spread({}).quantile[0]));
  CHECK(std::isnan(spread({7}).error));
}

TEST_CASE("each start of an ensemble equals its single run, for any number of threads", "[study][ensemble]") {
  const auto scene = rig();
  EnsemblePlan plan{.starts = 5, .rows = 11, .columns = {"slider.x", "gudgeon.gap"}, .threads = 2};
  const auto all = run_ensemble(*scene, plan, {});
  plan.threads = 1;
  const auto alone = run_ensemble(*scene, plan, {});
  REQUIRE(all.finished() == 5);
  REQUIRE(all.runs.size() == 5);
  CHECK(all.steps == alone.steps);
  for (std::size_t k = 0; k < 5; ++k)
    for (std::size_t i = 0; i < all.statistics.size(); ++i)
      CHECK(test::same_number(all.runs[k][i], alone.runs[k][i]));
  CHECK(all.t.front() == scene->run.discard);
  CHECK(all.t.back() == Approx(scene->run.duration));
  // The final position of the slider, from single runs of the same starts: bit-identical extremes.
  double least = INFINITY, greatest = -INFINITY, least_gap = INFINITY;
  for (int k = 0; k < 5; ++k) {
    Simulation simulation(perturbed(*scene, {}, plan.seed, k, plan.how), plan.formulation, {.matched = true});
    simulation.run();
    const double x = simulation.state().q[6];
    least = std::min(least, x);
    greatest = std::max(greatest, x);
    const System system(scene->mechanism);
    auto e = system.make_evaluation();
    system.place(simulation.state().t, simulation.state().q.data(), e);
    least_gap = std::min(least_gap, system.gap(0, simulation.state().q.data(), e));
  }
  CHECK(all.band(10, 1).of.least == Approx(least_gap).epsilon(1e-12));
  const auto& last = all.band(10, 0);
  CHECK(last.of.least == least);
  CHECK(last.of.greatest == greatest);
  CHECK(last.quantile[0] <= last.quantile[2]);
}

TEST_CASE("invalid ensembles are refused in one line", "[study][ensemble]") {
  const auto says = [](const EnsemblePlan& plan) {
    return test::refusal_of([&] { run_ensemble(*rig(), plan, {}); });
  };
  CHECK_THAT(says({.starts = 2, .columns = {"nobody.x"}}), Contains("--column nobody.x: is not a column"));
  CHECK_THAT(says({.starts = 1'000'000, .rows = 10'000}), Contains("--rows 10000") && Contains("fewer rows"));
  const auto still = open_scene(test::source_folder() / "cases/pendulum/scene.toml");
  CHECK_THROWS_WITH(run_ensemble(*still, {.starts = 2}, {}), Contains("all starts are identical"));
}

TEST_CASE("an ensemble computed in shards equals the whole ensemble, for any number and order",
          "[study][ensemble][shards]") {
  const auto scene = rig();
  const EnsemblePlan plan{.starts = 7, .rows = 5, .threads = 1};
  const auto whole = run_ensemble(*scene, plan, {});
  CHECK(whole.columns == std::vector<std::string>{"gudgeon.gap"});
  const auto study = divided_ensemble(*scene, plan, {"scene.toml"});
  const std::size_t shards = GENERATE(1u, 3u, 7u);
  const test::TemporaryFolder folder;
  make_plan(study, folder.path(), shards);
  for (std::size_t i = 0; i < shards; ++i) {
    const auto k = 1 + (i * 2 + 1) % shards;  // each once: the number of shards is odd
    const ShardRequest requested{.shard = k, .scratch = folder.path() / "scratch", .threads = 2};
    CHECK(make_shard(study, folder.path(), requested).seal.failed == 0);
    CHECK(make_shard(study, folder.path(), requested).found);
  }
  CHECK(merge_shards(study, folder.path(), folder.path() / "scratch").units == 7);
  const EnsembleStore store(folder.path() / "ensemble.db");
  const auto merged = run_ensemble(*scene, plan, {}, &store);
  CHECK(merged.cpu_seconds == 0);  // all starts are in the store
  CHECK(merged.steps == whole.steps);
  REQUIRE(merged.statistics == whole.statistics);
  for (std::size_t k = 0; k < 7; ++k)
    for (std::size_t i = 0; i < whole.statistics.size(); ++i)
      CHECK(test::same_number(merged.runs[k][i], whole.runs[k][i]));
  for (std::size_t i = 0; i < whole.bands.size(); ++i)
    for (std::size_t q = 0; q < band_levels.size(); ++q)
      CHECK(test::same_number(merged.bands[i].quantile[q], whole.bands[i].quantile[q]));
  // A start belongs to larger ensembles too, and to none of another scene or seed.
  auto larger = plan;
  larger.starts = 9;
  const auto key = run_key(identity(*scene, plan), 3);
  CHECK(run_key(identity(*scene, larger), 3) == key);
  CHECK(divided_ensemble(*scene, larger, {}).subject != study.subject);
  larger.seed = 2;
  CHECK(run_key(identity(*scene, larger), 3) != key);
}

TEST_CASE("a start with another key than its unit in the plan is not stored", "[study][ensemble][shards]") {
  const auto scene = rig();
  const EnsemblePlan plan{.starts = 2, .rows = 2, .threads = 1};
  const auto study = divided_ensemble(*scene, plan, {"scene.toml"});
  const test::TemporaryFolder folder;
  make_plan(study, folder.path(), 1);
  const auto file = shards_folder(folder.path()) / "units.txt";
  auto units = test::file_text(file);
  units[0] = units[0] == '0' ? '1' : '0';
  write_file(file, units);
  CHECK_THROWS_WITH(make_shard(study, folder.path(), {.scratch = folder.path() / "scratch", .threads = 1}),
                    Contains("differs from the planned one"));
}

namespace {

/// Two equal gears whose centres are 0.1 m apart, with a backlash of 0.1 mm; the first is driven.
Scene gears() {
  return parse_scene(
      test::body("a", 1, 0.01) + test::body("b", 1, 0.01, "position = [0.1, 0]\n") +
          test::pin("left", "ground", "a") + test::pin("right", "ground", "b", {0.1, 0}) +
          test::joint("mesh", "gear", "a", "b", {}, {},
                      "teeth = [20, 20]\nmodule = 5e-3\nbacklash = 1e-4\nsurface = \"hard\"\n") +
          test::surface("hard", 0.5, "young = 2e11\npoisson = 0.3\n") + test::motor("motor", "left", 1) +
          test::run_for(0.02),
      "gears.toml");
}

EnsemblePlan varying(const Scene& scene, const std::vector<std::string>& values, int starts = 2) {
  return {.starts = starts, .how = {.turn = 0, .vary = initial_values(scene.mechanism, values)}, .rows = 3};
}

}  // namespace

// Turning the second gear by δ about the middle of the backlash j moves its flank by r_b δ along the
// line of action: gaps j/2 ± r_b δ, with the base radius r_b = 0.05 m cos 20°. Forty uniform values
// all miss an outer quarter of their range with a probability of (3/4)^40 = 1e-5.
TEST_CASE("an ensemble varies the angle of a gear within its backlash, the only play", "[study][ensemble]") {
  const auto scene = gears();
  CHECK_THROWS_WITH(run_ensemble(scene, {.starts = 2}, {}),
                    Contains("all starts are identical") && Contains("--vary KEY=RANGE"));
  const double base = 0.05 * std::cos(20 * std::numbers::pi / 180), half = 0.9 * 0.5e-4 / base;
  const auto plan = varying(scene, {fmt::format("bodies.b.angle={}", half)}, 40);
  const auto still = Simulation(scene, plan.formulation, {.matched = true}).state();
  double least = 0, greatest = 0;
  for (int k = 0; k < plan.starts; ++k) {
    const auto moved = perturbed(scene, {}, plan.seed, k, plan.how);
    const auto state = Simulation(moved, plan.formulation, {.matched = true}).state();
    const System system(moved.mechanism);
    auto e = system.make_evaluation();
    system.place(0, state.q.data(), e);
    const double one = system.gap(0, state.q.data(), e), other = system.gap(1, state.q.data(), e),
                 turned = state.q[5] - still.q[5];
    CHECK(one + other == Approx(1e-4).epsilon(1e-9));
    CHECK(std::abs(one - other) / 2 == Approx(base * std::abs(turned)).margin(1e-13));
    for (const std::size_t c : {0u, 1u, 2u, 3u, 4u}) CHECK(state.q[c] == Approx(still.q[c]).margin(1e-12));
    CHECK(state.v[5] == Approx(-1).epsilon(1e-12));
    least = std::min(least, turned), greatest = std::max(greatest, turned);
  }
  CHECK(least >= -half * (1 + 1e-9));
  CHECK(least < -half / 2);
  CHECK(greatest <= half * (1 + 1e-9));
  CHECK(greatest > half / 2);
  const auto all = run_ensemble(scene, varying(scene, {fmt::format("bodies.b.angle={}", half)}, 3), {});
  CHECK(all.finished() == 3);
  CHECK(all.band(0, 0).of.greatest > all.band(0, 0).of.least);
  CHECK(run_key(identity(scene, plan), 0) != run_key(identity(scene, {.rows = 3}), 0));
}

// The pin is 0.3 m from the centre of mass, in the direction −x of the bar: the centre is at
// 0.3 (cos θ, sin θ) and moves at ω × r.
TEST_CASE("bodies follow a varied coordinate through their joints", "[study][ensemble]") {
  const auto scene = open_scene(test::source_folder() / "cases/pendulum/scene.toml");
  const auto plan = varying(*scene, {"bodies.bar.angle=20 deg", "bodies.bar.angular_velocity=2"}, 4);
  for (int k = 0; k < plan.starts; ++k) {
    const auto moved = perturbed(*scene, {}, plan.seed, k, plan.how);
    const auto s = Simulation(moved, plan.formulation, {}).state();
    CHECK(s.q[2] != 0);
    CHECK(std::abs(s.q[2]) <= 20 * std::numbers::pi / 180);
    CHECK(s.q[0] == Approx(0.3 * std::cos(s.q[2])).epsilon(1e-12));
    CHECK(s.q[1] == Approx(0.3 * std::sin(s.q[2])).margin(1e-12));
    CHECK(s.v[2] != 0);
    CHECK(std::abs(s.v[2]) <= 2);
    CHECK(s.v[0] == Approx(-s.v[2] * s.q[1]).margin(1e-12));
    CHECK(s.v[1] == Approx(s.v[2] * s.q[0]).margin(1e-12));
  }
  CHECK(run_ensemble(*scene, plan, {}).finished() == 4);
}

TEST_CASE("varied values leave the random positions of joints with clearance as they are",
          "[study][ensemble]") {
  const auto scene =
      parse_scene(test::body("bar", 1, 0.1) + test::body("free", 1, 0.1, "position = [1, 1]\n") +
                      test::pin("pin", "ground", "bar", {}, {-0.3, 0}, test::loose(1e-3, 0.01)) +
                      test::surface("s", 0.5, 0.1) + test::run_for(0.1),
                  "loose.toml");
  const EnsemblePlan plain;
  const auto plan = varying(scene, {"bodies.free.position[1]=0.5", "bodies.free.velocity[0]=3"});
  for (int k = 0; k < 4; ++k) {
    const auto one = perturbed(scene, {}, plan.seed, k, plain.how).mechanism.bodies,
               other = perturbed(scene, {}, plan.seed, k, plan.how).mechanism.bodies;
    CHECK(one[0].position == *other[0].position);
    CHECK(one[0].angle == other[0].angle);
    CHECK(one[1].position->x() == other[1].position->x());
    CHECK(std::abs(other[1].position->y() - 1) <= 0.5);
    CHECK(other[1].position->y() != 1);
    CHECK(std::abs(other[1].velocity->x()) <= 3);
    CHECK(other[1].velocity->x() != 0);
  }
}

TEST_CASE("starts keep the given velocities of bodies in a joint with clearance", "[study][ensemble]") {
  // The ideal joint would make both bodies move as one.
  const auto scene =
      parse_scene(test::body("a", 1, 0.1, "position = [0, 0]\nvelocity = [1, 0]\nangular_velocity = 2\n") +
                      test::body("b", 2, 0.1, "position = [0, 0]\nvelocity = [-0.5, 0.25]\n") +
                      test::pin("pin", "a", "b", {}, {}, test::loose(1e-3, 0.01)) +
                      test::surface("s", 0.5, 0.1) + test::run_for(0.1, "start = \"given\"\n"),
                  "free.toml");
  for (int k = 0; k < 4; ++k) {
    const auto moved = perturbed(scene, {}, 1, k, {});
    const auto s = Simulation(moved, "nonsmooth", {}).state();
    CHECK(std::hypot(s.q[3] - s.q[0], s.q[4] - s.q[1]) < 1e-3);
    CHECK(s.q != Simulation(scene, "nonsmooth", {}).state().q);
    CHECK(s.v == std::vector<double>{1, 0, 2, -0.5, 0.25, 0});
  }
}

TEST_CASE("values that joints or drives determine are not varied", "[study][ensemble]") {
  const auto scene = gears();
  const auto says = [&](const std::vector<std::string>& values) {
    return test::refusal_of([&] { run_ensemble(scene, varying(scene, values), {}); });
  };
  CHECK_THAT(says({"bodies.a.angle=0.01"}), Contains("--vary bodies.a.angle: ") && Contains("drives.motor"));
  CHECK_THAT(says({"bodies.a.angular_velocity=1"}), Contains("drives.motor") && Contains("rad/s"));
  CHECK_THAT(says({"bodies.b.position[0]=1 mm"}), Contains("joints.right") && Contains("0.001 m"));
  CHECK_THAT(says({"bodies.b.velocity[1]=0.1"}), Contains("joints.right"));
  CHECK_THAT(says({"bodies.c.angle=0.1"}), Contains("is no initial value of a body"));
  CHECK_THAT(says({"bodies.b.angle=1 mm"}), Contains("is a length"));
  CHECK_THAT(says({"bodies.b.angle=0"}), Contains("must be a positive number in rad"));
  CHECK_THAT(says({"bodies.b.angle"}), Contains("must be KEY=RANGE"));
  CHECK_THAT(says({"bodies.b.angle=1e-4", "bodies.b.angle=2e-4"}), Contains("is given twice"));
}
