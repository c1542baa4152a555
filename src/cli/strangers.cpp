#include "cli/strangers.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>

#include "cli/document.hpp"
#include "cli/progress.hpp"
#include "io/files/folder_lock.hpp"
#include "io/files/output_file.hpp"
#include "verification/strangers/strangers.hpp"

namespace freeplay::cli {

int strangers(const StrangersRequest& request, const std::filesystem::path& folder) {
  using namespace verification;
  using namespace verification::strangers;
  const auto seed = static_cast<std::uint64_t>(request.seed);
  make_folder(folder);
  const FolderLock lock(folder, "extremes");
  const auto began = std::chrono::steady_clock::now();
  std::vector<Row> rows;
  if (request.only >= 0) {
    const auto stranger = draw(seed, request.only);
    write_file(folder / "scene.toml", stranger.text);
    rows = judge_one(stranger);
    for (const auto& r : rows)
      fmt::print("{:<14}{:<9}{:>7.2g} s  {} {}\n", r.way, word_for(r.verdict.outcome), r.verdict.cpu,
                 r.verdict.check, r.verdict.detail);
    fmt::print("its scene: {}\n", (folder / "scene.toml").string());
  } else {
    Progress progress;
    rows = judge_all(seed, request.count, [&](double done) { progress.show("strangers", done); });
    progress.clear();
  }
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
  std::string csv = "seed,index,kind,way,outcome,check,detail\n";
  int defects = 0;
  for (const auto& r : rows) {
    auto detail = r.verdict.detail, check = r.verdict.check;
    std::ranges::replace(detail, ',', ';');
    csv += fmt::format("{},{},{},{},{},{},{}\n", seed, r.index, r.kind, r.way, word_for(r.verdict.outcome),
                       check.empty() ? "-" : check, detail.empty() ? "-" : detail);
    defects += is_defect(r.verdict.outcome);
  }
  write_file(folder / "strangers.csv", csv);
  if (request.only < 0) {
    fmt::print("{}\n{}\n{}\n", table_of(rows), refusals_of(rows), told_of(rows));
    for (const auto& r : rows)
      if (is_defect(r.verdict.outcome))
        fmt::print("{} {} ({}, {}): {}: {}\n    freeplay extremes --strangers {} --seed {} --only {}\n",
                   word_for(r.verdict.outcome), r.index, r.kind, r.way, r.verdict.check, r.verdict.detail,
                   request.count, seed, r.index);
    fmt::print("{} strangers of seed {}, {} runs judged in {:.0f} s: {} defects\nresults in {}\n",
               request.count, seed, rows.size(), seconds, defects, folder.string());
    if (!request.document.empty()) {
      const auto place = real_folder(request.document);
      const auto document = lock_document(place, folder, "extremes");
      write_file(place / "strangers.md", page_of(rows, seed, request.count, seconds));
    }
  }
  return defects == 0 ? 0 : 1;
}

}  // namespace freeplay::cli
