// freeplay ensemble: runs from perturbed starts of one mechanism, with statistics and bands.
#include "study/ensemble/ensemble.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <optional>

#include "cli/cluster/shards.hpp"
#include "cli/command_line.hpp"
#include "cli/figures.hpp"
#include "cli/folders.hpp"
#include "cli/terminal.hpp"
#include "facade/identify.hpp"
#include "io/files/result_set.hpp"
#include "io/files/run_json.hpp"
#include "io/scene/read_scene.hpp"
#include "mechanism/scene.hpp"
#include "study/partition/divided.hpp"
#include "values/family.hpp"
#include "values/table.hpp"

namespace freeplay::cli {
namespace {

struct EnsembleVerb : Request {
  std::string scene, output, formulation = "nonsmooth";
  std::vector<std::string> overrides, columns, vary;
  int starts = 100, seed = 1, rows = 200, threads = 0;
  double turn = 0, play = 0.9;
  ShardOptions shards;
};

/// The command line with absolute paths, for the processes that compute shards.
std::vector<std::string> arguments_of(const EnsembleVerb& r) {
  auto list = study_arguments(r.scene, Reach::beside);
  for (const auto& word : r.overrides) list.insert(list.end(), {"--set", word});
  for (const auto& [name, value] : {std::pair{"--formulation", r.formulation},
                                    {"--starts", std::to_string(r.starts)},
                                    {"--seed", std::to_string(r.seed)},
                                    {"--turn", fmt::format("{}", r.turn)},
                                    {"--play", fmt::format("{}", r.play)},
                                    {"--rows", std::to_string(r.rows)}})
    list.insert(list.end(), {name, value});
  for (const auto& value : r.vary) list.insert(list.end(), {"--vary", value});
  for (const auto& column : r.columns) list.insert(list.end(), {"--column", column});
  return list;
}

/// Prints a selection for a terminal: statistics of contacts and energy, or whatever exists.
void show(const Ensemble& all) {
  Table table(",mean,± (95 %),median");
  for (std::size_t i = 0; i < all.statistics.size() && table.rows().size() < 30; ++i) {
    const auto& s = all.spreads[i];
    if (s.of.least == s.of.greatest || all.statistics[i].size() > 43) continue;
    table.row(all.statistics[i], fmt::format("{:.5g}", s.of.mean),
              fmt::format("{:.2g}", 0.5 * (s.of.high - s.of.low)), fmt::format("{:.5g}", s.quantile[2]));
  }
  fmt::print("{}all statistics are in statistics.csv\n\n", table.terminal({44, 12, 11, 12}));
}

int ensemble(const EnsembleVerb& request) {
  const auto scene = open_scene(request.scene, request.overrides);
  const EnsemblePlan plan{.formulation = request.formulation,
                          .starts = request.starts,
                          .seed = static_cast<std::uint64_t>(request.seed),
                          .how = {.turn = request.turn,
                                  .play = request.play,
                                  .vary = initial_values(scene->mechanism, request.vary)},
                          .rows = request.rows,
                          .columns = request.columns,
                          .threads = request.threads,
                          .stop = request.stop};
  const auto folder = result_folder(request.output, default_folder(request.scene, "-ensemble"));
  if (request.shards.requested())
    return in_shards(divided_ensemble(*scene, plan, arguments_of(request)), request.shards, folder,
                     request.threads, request.stop);
  ResultSet set(folder, "ensemble");
  // Do not repeat starts that were merged from shards into this folder.
  std::optional<EnsembleStore> store;
  if (const auto file = folder / "ensemble.db"; std::filesystem::exists(file))
    store.emplace(file, Database::Access::read, request.stop);
  Progress progress;
  const auto all = run_ensemble(
      *scene, plan, [&](double done) { progress.show(fmt::format("{} starts", plan.starts), done); },
      store ? &*store : nullptr);
  progress.clear();
  if (all.interrupted) {
    fmt::print("interrupted; nothing was written\n");
    return 1;
  }
  write_json(set.place() / "ensemble.json", to_json(plan, all),
             provenance(*scene, identify(*scene, plan.formulation, true)));
  write_file(set.place() / "statistics.csv", statistics_table(all).csv());
  write_file(set.place() / "starts.csv", runs_table(all).csv());
  write_file(set.place() / "bands.csv", bands_table(all).csv());
  set.commit();
  fmt::print("{} starts, {} finished, in {:.3g} s\n\n", plan.starts, all.finished(), all.wall_seconds);
  show(all);
  draw_results(folder, Undrawn::is_error);
  for (std::size_t k = 0; k < all.failures.size(); ++k)
    if (!all.failures[k].empty()) fmt::print(stderr, "start {}: {}\n", k, all.failures[k]);
  return all.finished() == all.failures.size() ? 0 : 1;
}

}  // namespace

void ensemble_verb(Program& program) {
  auto [options, request] = program.verb(
      "ensemble", "run perturbed starts of one mechanism: statistics with error bars, and bands", ensemble);
  options.scene(request.scene).required();
  options.formulation(request.formulation);
  options.set(request.overrides);
  options.add("--starts", request.starts, "how many").between(2, 1'000'000).shows_default();
  options.add("--seed", request.seed, "seed of the random starts").between(0, 2'000'000'000).shows_default();
  options.add("--turn", request.turn, "range of the random initial crank angle, as a share of a revolution")
      .number([](double x) { return x >= 0 && x <= 1; }, "must be from 0 to 1")
      .shows_default();
  options.add("--play", request.play, "range of the random initial offsets, as a share of the clearance")
      .number([](double x) { return x >= 0 && x < 1; }, "must be from 0 to less than 1")
      .shows_default();
  options
      .add("--vary", request.vary,
           "random initial value of a body: its key, such as bodies.wheel.angle, and half the range, such as "
           "\"1 deg\"; may be repeated")
      .takes("KEY=RANGE")
      .one_each();
  options.add("--column", request.columns, "column of trajectory.csv for a band; may be repeated")
      .takes("COLUMN")
      .one_each();
  options.add("--rows", request.rows, "number of times in the bands").between(2, 1'000'000).shows_default();
  options.threads(request.threads);
  declare_shards(options, request.shards);
  options.output(request.output, "result folder; default out/NAME-ensemble");
}

}  // namespace freeplay::cli
