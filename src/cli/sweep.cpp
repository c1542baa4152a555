// freeplay sweep: executes the missing runs of a study on all cores, into one SQLite file.
#include <fmt/format.h>

#include <algorithm>

#include <cmath>
#include <map>

#include "cli/cluster/shards.hpp"
#include "cli/command_line.hpp"
#include "cli/ending.hpp"
#include "cli/folders.hpp"
#include "cli/terminal.hpp"
#include "io/files/escaping.hpp"
#include "io/files/folder_lock.hpp"
#include "io/files/output_file.hpp"
#include "mechanism/error.hpp"
#include "study/partition/divided.hpp"
#include "study/settings/study.hpp"
#include "study/sweep/sweep.hpp"
#include "study/sweep/sweep_table.hpp"
#include "study/verdicts/verdicts.hpp"

namespace freeplay::cli {
namespace {

std::string left(double seconds) {
  if (seconds < 90) return fmt::format("{:.0f} s", seconds);
  return fmt::format("{:.0f} min", seconds / 60);
}

struct SweepRequest : StudyRequest {
  std::string table;            ///< CSV file in the result folder for all named runs; empty: none
  std::string spectra, traces;  ///< likewise for spectra and traces
  bool prune = false;           ///< delete the runs that the study does not name, and execute none
};

/// Prints which runs the study does not name, and deletes them.
int prune(const Study& study, const std::vector<PlannedRun>& planned, const std::filesystem::path& folder,
          const SweepRequest& request) {
  const FolderLock lock(folder, "sweep --prune");
  Results results(folder / "sweep.db", study, request.stop);
  std::vector<std::string> keys;
  for (const auto& run : planned) keys.push_back(run.key);
  const WorkList work(results.database(), lock, keys, WorkList::Earlier::kept);
  std::size_t all = 0;
  for (const auto& [variant, formulation, count] : results.kept()) {
    fmt::print("{}, {}: {} runs that are not part of the study\n", variant, formulation, count);
    all += count;
  }
  std::fflush(stdout);
  results.prune();
  fmt::print("{} removed from {}; {} of the {} runs of the study are there\n", all,
             (folder / "sweep.db").string(), work.found(), planned.size());
  return 0;
}

/// Requires a plain file name: outputs are in the result folder.
void require_plain(const char* option, const std::string& file) {
  if (file.empty()) return;
  const std::filesystem::path path(file);
  if (path.has_parent_path() || path.extension() != ".csv" || path.stem().empty() || file.front() == '.')
    throw SceneError(fmt::format("{} {}: must be the name of a file in the result folder, NAME.csv", option,
                                 visible(file)));
}

int sweep(const SweepRequest& request) {
  require_plain("--export", request.table);
  require_plain("--spectra", request.spectra);
  require_plain("--traces", request.traces);
  const auto study = read_study(request.study, request.reach);
  const auto folder = result_folder(request.output, default_folder(study.file, ""));
  if (request.shards.requested())
    return in_shards(divided_sweep(study, request.conduct(), "sweep",
                                   study_arguments(request.study, request.reach), subject_of(study)),
                     request.shards, folder, request.threads, request.stop);
  const auto planned = plan(study, request.conduct(), request.threads);
  if (request.stop()) return interrupted(Kept::nothing);
  if (request.prune && !std::filesystem::exists(folder / "sweep.db"))
    throw SceneError(fmt::format("{}: has no sweep.db to remove runs from", folder.string()));
  if (request.prune) return prune(study, planned, folder, request);
  make_folder(folder);
  const FolderLock lock(folder, "sweep", FolderLock::Use::together);
  Results results(folder / "sweep.db", study, request.stop);
  Progress progress;
  const auto summary = freeplay::sweep(
      study, planned, request.conduct(), results, lock, request.threads, [&](const SweepProgress& p) {
        progress.show(fmt::format("{} of {} runs, {} left", p.done, p.total, left(p.seconds_left)),
                      static_cast<double>(p.done) / static_cast<double>(p.total));
      });
  progress.clear();
  fmt::print("{} runs: {} from the store, {} new in {}, {} of them failed\n", summary.total, summary.found,
             summary.ran, left(summary.wall_seconds), summary.failed);
  if (!study.design.where.empty())
    fmt::print("`where` selects {} of {} cells\n", cells(study).size(), unfiltered(study));
  if (summary.elsewhere > 0) fmt::print("{} made by other processes in the meantime\n", summary.elsewhere);
  if (summary.lost > 0)
    fmt::print("{}",
               wrapped(fmt::format("{} were started by a process that ended without storing them, and were "
                                   "repeated\n",
                                   summary.lost)));
  if (summary.kept > 0)
    fmt::print("{}",
               wrapped(fmt::format("{} further runs are kept, of an earlier form of the study or another "
                                   "program; --prune removes them\n",
                                   summary.kept)));
  fmt::print("\n");
  results.derive(study);
  write_sweep_document(study, results, folder);
  const auto runs = results.runs();
  if (!summary.interrupted) fmt::print("{}", sweep_table(study, runs));
  const auto doubtful = [](const RunRow& r) { return !r.doubt.empty(); };
  if (const auto count = std::ranges::count_if(runs, doubtful); count > 0)
    fmt::print("{}", wrapped(fmt::format("{} of the runs have warnings (runs.reason), for example: {}\n",
                                         count, std::ranges::find_if(runs, doubtful)->doubt)));
  for (const auto& [variant, formulation, reason] : results.failures())
    fmt::print(stderr, "{}, {}: {}\n", variant, formulation, reason);
  fmt::print("results in {}\n", (folder / "sweep.db").string());
  if (!request.table.empty()) {
    write_export(study, results, folder / request.table);
    fmt::print("table in {}\n", (folder / request.table).string());
  }
  if (!request.spectra.empty()) write_spectra(results, folder / request.spectra);
  if (!request.traces.empty()) write_traces(results, folder / request.traces);
  if (summary.interrupted) return interrupted(Kept::runs);
  const auto failures = results.failures().size();
  const auto conclusion = verdict(sweep_values(study, runs, failures));
  write_sweep_document(study, results, folder, conclusion);
  fmt::print("\n{}", wrapped(conclusion + "\n", 0));
  return failures == 0 ? 0 : 1;
}

}  // namespace

void sweep_verb(Program& program) {
  auto [options, request] = program.verb("sweep",
                                         "run a parameter study on all cores, skipping runs already "
                                         "stored",
                                         sweep);
  declare_study(options, request, "study file", "result folder; default out/NAME");
  options
      .add("--export", request.table,
           "write the runs of the study as a table NAME.csv into the result folder")
      .takes("NAME.csv");
  options.add("--spectra", request.spectra, "write their spectra likewise, one harmonic per line")
      .takes("NAME.csv");
  options
      .add("--traces", request.traces,
           "write the last revolutions of start 0 likewise, one sample per "
           "line")
      .takes("NAME.csv");
  options.flag("--prune", request.prune,
               "list and remove stored runs that are not part of the study; run nothing");
}

}  // namespace freeplay::cli
