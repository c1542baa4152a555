// freeplay sweep: a study's missing runs, on all cores, into one SQLite file.
#include <fmt/format.h>

#include <algorithm>

#include <cmath>
#include <map>

#include "cli/default_folder.hpp"
#include "cli/progress.hpp"
#include "cli/verb.hpp"
#include "cli/wrapped.hpp"
#include "io/output_file.hpp"
#include "study/intervals.hpp"
#include "study/sweep.hpp"

namespace freeplay::cli {
namespace {

std::string left(double seconds) {
  if (seconds < 90) return fmt::format("{:.0f} s", seconds);
  return fmt::format("{:.0f} min", seconds / 60);
}

struct SweepRequest : Request {
  std::string scene;  ///< the study's file
  Reach reach = Reach::beside;
  std::string output;  ///< result folder
  int threads = 0;     ///< 0 for all cores
};

int sweep(const SweepRequest& request) {
  const auto study = read_study(request.scene, request.reach);
  const auto folder = result_folder(request.output, default_folder(study.file, ""));
  make_folder(folder);
  Results results(folder / "sweep.db", study);
  Progress progress;
  const auto summary =
      freeplay::sweep(study, request.conduct(), results, request.threads, [&](const SweepProgress& p) {
        progress.show(fmt::format("{} of {} runs, {} left", p.done, p.total, left(p.seconds_left)),
                      static_cast<double>(p.done) / static_cast<double>(p.total));
      });
  progress.clear();
  fmt::print("{} runs: {} were there, {} made in {}, {} of them failed\n\n", summary.total, summary.found,
             summary.ran, left(summary.wall_seconds), summary.failed);
  if (summary.dropped > 0)
    fmt::print("{} dropped: of an earlier form of the study, or made by another program\n\n",
               summary.dropped);
  const auto runs = results.runs();
  if (!summary.interrupted) fmt::print("{}", sweep_table(study, runs));
  const auto doubtful = [](const RunRow& r) { return !r.doubt.empty(); };
  if (const auto count = std::ranges::count_if(runs, doubtful); count > 0)
    fmt::print("{}",
               wrapped(fmt::format("{} of the runs are doubtful; runs.reason says why, for example: {}\n",
                                   count, std::ranges::find_if(runs, doubtful)->doubt)));
  for (const auto& [variant, formulation, reason] : results.failures())
    fmt::print(stderr, "{}, {}: {}\n", variant, formulation, reason);
  fmt::print("results in {}\n", (folder / "sweep.db").string());
  if (summary.interrupted) fmt::print("interrupted; the same command carries on\n");
  return summary.interrupted || !results.failures().empty() ? 1 : 0;
}

}  // namespace

void sweep_verb(Program& program) {
  auto [options, request] = program.verb("sweep", "run what is missing of a study, on all cores", sweep);
  options.add("study", request.scene, "study file").required();
  options.output(request.output, "result folder; default out/NAME");
  options.allow_outside(request.reach);
  options.threads(request.threads);
}

}  // namespace freeplay::cli
