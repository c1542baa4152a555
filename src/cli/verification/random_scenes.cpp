#include "cli/verification/random_scenes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>

#include "cli/default_folder.hpp"
#include "cli/document.hpp"
#include "cli/progress.hpp"
#include "io/files/folder_lock.hpp"
#include "io/files/output_file.hpp"
#include "verification/random_scenes/page.hpp"

namespace freeplay::cli {
namespace {

using namespace verification::random_scenes;

/// Tests one scene: writes its files, and prints a line for each way.
std::vector<Row> judge_only(const RandomScene& scene, const std::string& way,
                            const std::filesystem::path& folder) {
  const bool known = scene.suite == Suite::rows;
  const auto rows = judge_apart(scene, way);
  if (!known) write_file(folder / "scene.toml", scene.text);
  for (const auto& by : ways(scene.suite))
    if (known && (way.empty() || way == by.name) && has_model(scene, by))
      write_file(folder / fmt::format("{}.toml", by.name), text_for(scene, by));
  for (const auto& r : rows)
    fmt::print("{:<24}{:<16}{:>8.2g} s  {} {}\n", r.way, name_of(r.verdict.outcome, scene.suite),
               r.verdict.cpu, r.verdict.check, r.verdict.detail);
  fmt::print("kind {}, in {}\n", scene.kind, folder.string());
  return rows;
}

std::string table_file(const std::vector<Row>& rows, std::uint64_t seed) {
  std::string csv = "seed,index,kind,way,outcome,check,detail\n";
  for (const auto& r : rows) {
    auto detail = r.verdict.detail;
    std::ranges::replace(detail, ',', ';');
    csv += fmt::format("{},{},{},{},{},{},{}\n", seed, r.index, r.kind, r.way,
                       name_of(r.verdict.outcome, Suite::agreement),
                       r.verdict.check.empty() ? "-" : r.verdict.check, detail.empty() ? "-" : detail);
  }
  return csv;
}

}  // namespace

int random_scenes(const RandomScenesRequest& request, const std::string& output) {
  const verification::random_scenes::Request requested{
      static_cast<std::uint64_t>(request.seed), request.first, request.count, request.kinds, request.way};
  const bool known = !requested.kinds.empty();
  const auto folder = result_folder(output, known ? "out/random-scenes" : "out/strangers");
  make_folder(folder);
  const FolderLock lock(folder, "extremes");
  const auto began = std::chrono::steady_clock::now();
  const bool all = request.only < 0;
  std::vector<Row> rows;
  if (all) {
    Progress progress;
    rows = judge_all(requested, folder, [&](double done) { progress.show("random scenes", done); });
    progress.clear();
  } else {
    rows = judge_only(draw(requested.seed, request.only, requested.kinds), requested.way, folder);
  }
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
  const auto suite = known ? Suite::rows : Suite::agreement;
  const auto defect = [&](const Row& r) { return is_defect(r.verdict.outcome, suite); };
  const auto defects = std::ranges::count_if(rows, defect);
  if (!known) write_file(folder / "strangers.csv", table_file(rows, requested.seed));
  if (all) {
    const auto text = table_of(rows, suite) + "\n" +
                      (known ? defects_by_kind(rows) : refusals_of(rows) + "\n" + noted_of(rows));
    if (known) write_file(folder / "random_scenes.md", text);
    fmt::print("{}\n", text);
    for (const auto& r : rows)
      if (!known && defect(r))
        fmt::print("{} {} ({}, {}): {}: {}\n    freeplay extremes --random-scenes {} --seed {} --only {}\n",
                   name_of(r.verdict.outcome, suite), r.index, r.kind, r.way, r.verdict.check,
                   r.verdict.detail, requested.count, requested.seed, r.index);
    fmt::print("{} random scenes of seed {}, {} runs tested in {:.0f} s: {} defects\nresults in {}\n",
               requested.count, requested.seed, rows.size(), seconds, defects, folder.string());
    if (!known && !request.document.empty()) {
      const auto place = real_folder(request.document);
      const auto document = lock_document(place, folder, "extremes");
      write_file(place / "random-scenes.md", page_of(rows, requested.seed, requested.count, seconds));
    }
  }
  return defects == 0 ? 0 : 1;
}

}  // namespace freeplay::cli
