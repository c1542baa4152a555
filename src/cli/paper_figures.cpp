#include "cli/paper_figures.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "cli/default_folder.hpp"
#include "cli/ending.hpp"
#include "cli/progress.hpp"
#include "io/files/folder_lock.hpp"
#include "io/files/output_file.hpp"
#include "io/files/result_set.hpp"
#include "io/files/run_json.hpp"
#include "plots/figures/paper.hpp"
#include "study/settings/plan.hpp"
#include "study/settings/provenance.hpp"
#include "study/sweep/sweep.hpp"
#include "study/sweep/sweep_document.hpp"
#include "study/sweep/tables.hpp"

namespace freeplay::cli {
namespace {

/// A file of a paper's study, copied into the program.
struct PaperFile {
  const char *paper, *file, *text;
};
constexpr PaperFile paper_files[] = {
#include "papers.inc"
};
constexpr const char* study_of_paper = "figures.toml";

void print(const std::vector<std::filesystem::path>& figures) {
  for (const auto& path : figures) fmt::print("{}\n", path.string());
}

}  // namespace

std::vector<std::string> papers() {
  std::vector<std::string> names;
  for (const auto& one : paper_files)
    if (std::ranges::find(names, one.paper) == names.end()) names.emplace_back(one.paper);
  return names;
}

int paper_figures(const PaperRequest& request, const Conduct& conduct) {
  const auto folder =
      result_folder(request.output, std::filesystem::path("out") / ("paper-" + request.paper));
  if (std::filesystem::exists(folder / "experiment.json")) {
    const FolderLock lock(folder, "figures");
    settle_result_sets(folder);
    print(plots::draw_flores2011(folder, "experiment.json"));
    return 0;
  }
  ResultSet set(folder, "paper");
  for (const auto& one : paper_files)
    if (one.paper == request.paper) write_file(folder / one.file, one.text);
  const auto study = read_study(folder / study_of_paper, Reach::beside);
  const auto planned = plan(study, conduct);
  if (conduct.stop()) return interrupted(Kept::nothing);
  Results results(folder / "sweep.db", study, conduct.stop);
  fmt::print(stderr,
             "figures of {}: {} runs of {} variants, without those already stored in {}; takes minutes\n",
             request.paper, planned.size(), study.variants.size(), folder.string());
  Progress progress;
  const auto summary =
      sweep(study, planned, conduct, results, set.lock(), request.threads, progress.of_runs());
  progress.clear();
  if (summary.interrupted) return interrupted(Kept::runs);
  write_sweep_document(study, results, folder);
  nlohmann::json document;
  document["provenance"] = provenance(study);
  document["paper"] = {{"name", request.paper}, {"runs", summary.total}, {"failed", summary.failed}};
  write_json(set.place() / "paper.json", document);
  write_tables(study, results, conduct, set.place());
  set.commit();
  fmt::print("{} runs, {} of them new, in {:.0f} s; results in {}\n", summary.total, summary.ran,
             summary.wall_seconds, folder.string());
  print(plots::draw_flores2011(folder, "paper.json"));
  for (const auto& [variant, formulation, reason] : results.failures())
    fmt::print(stderr, "{}, {}: {}\n", variant, formulation, reason);
  return results.failures().empty() ? 0 : 1;
}

}  // namespace freeplay::cli
