// freeplay wear: wear of bearings over many turns, in cycles of runs and extrapolation.
#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "cli/cluster/shards.hpp"
#include "cli/command_line.hpp"
#include "cli/ending.hpp"
#include "cli/figures.hpp"
#include "cli/folders.hpp"
#include "cli/terminal.hpp"
#include "io/files/result_set.hpp"
#include "io/files/run_json.hpp"
#include "study/wear/wear_documents.hpp"

namespace freeplay::cli {
namespace {

struct WearRequest : Request {
  std::string study, output;
  Reach reach = Reach::beside;
  int threads = 0;
};

int wear(const WearRequest& request) {
  const auto study = read_study(request.study, request.reach);
  if (!study.wear)
    throw SceneError(fmt::format("{}: has no table [wear]; see docs/how-to/wear.md", request.study));
  const auto folder = result_folder(request.output, default_folder(study.file, "-wear"));
  require_wear(study, request.conduct());
  const auto origin = provenance(study);  // before the runs, since it reads the scene as the study names it
  ResultSet set(folder, "wear");
  EnsembleStore store(folder / "wear.db", Database::Access::write, request.stop);
  Progress progress;
  const auto all = wear_study(study, request.conduct(), store, request.threads, [&](const WearProgress& p) {
    progress.show(
        fmt::format("{}, {:.4g} turns, set {}: {} of {} runs", p.formulation, p.turns, p.set, p.done, p.runs),
        p.share);
  });
  progress.clear();
  if (all.interrupted) return interrupted(Kept::runs);
  write_json(set.place() / "wear.json", to_json(*study.wear, all), origin);
  write_file(set.place() / "wear.csv", wear_table(all).csv());
  write_file(set.place() / "profiles.csv", profiles_table(all).csv());
  for (const auto& file : profile_files(all)) write_file(set.place() / file.name, file.points.csv());
  write_file(set.place() / "wear.md", wear_page(study, all));
  set.commit();
  fmt::print("{} runs from the store, {} new, in {:.3g} s\n\n", all.found, all.made, all.wall_seconds);
  fmt::print("{}", wrapped(conclusion(*study.wear, all)));
  draw_results(folder, Undrawn::is_error, request.stop);
  for (const auto& failure : all.failures) fmt::print(stderr, "{}\n", failure);
  return all.failures.empty() ? 0 : 1;
}

}  // namespace

void wear_verb(Program& program) {
  auto [options, request] =
      program.verb("wear", "compute the wear of bearings over many turns: profiles, depth, life", wear);
  options.add("study", request.study, "study file with a table [wear]").required();
  options.threads(request.threads);
  options.allow_outside(request.reach);
  options.output(request.output, "result folder; default out/NAME-wear");
}

}  // namespace freeplay::cli
