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
