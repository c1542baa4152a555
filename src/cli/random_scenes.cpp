#include "cli/random_scenes.hpp"

#include <fmt/format.h>

#include <chrono>

#include "cli/progress.hpp"
#include "io/files/folder_lock.hpp"
#include "io/files/output_file.hpp"
#include "verification/random_scenes/random_scenes.hpp"

namespace freeplay::cli {

int random_scenes(const StrangersRequest& request, const std::filesystem::path& folder) {
  using namespace verification::random_scenes;
  make_folder(folder);
  const FolderLock lock(folder, "extremes");
  verification::random_scenes::Request asked{static_cast<std::uint64_t>(request.seed), request.first,
                                             request.count, request.kinds, request.way};
  if (request.only >= 0) {
    const auto scene = draw(asked.seed, request.only, request.kinds);
    int defects = 0;
    for (const auto& way : ways())
      if ((request.way.empty() || request.way == way.name) &&
          (way.family == Family::nonsmooth || scene.penalty))
        write_file(folder / fmt::format("{}.toml", way.name), text_for(scene, way));
    judge(scene, request.way, [&](const Way& way, const Verdict& v) {
      fmt::print("{:<24}{:<16}{:>8.2g} s  {}\n", way.name, name_of(v.outcome), v.cpu, v.what);
      defects += is_defect(v.outcome);
    });
    fmt::print("kind {}, its scenes: {}\n", scene.kind, folder.string());
    return defects == 0 ? 0 : 1;
  }
  const auto began = std::chrono::steady_clock::now();
  Progress progress;
  const auto judgements =
      judge_all(asked, folder, [&](double done) { progress.show("random scenes", done); });
  progress.clear();
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
  int defects = 0;
  for (const auto& j : judgements) defects += is_defect(j.verdict.outcome);
  const auto text = tables(judgements);
  write_file(folder / "random_scenes.md", text);
  fmt::print("{}\n{} random scenes of seed {}, {} runs judged in {:.0f} s: {} defects\nresults in {}\n", text,
             request.count, request.seed, judgements.size(), seconds, defects, folder.string());
  return defects == 0 ? 0 : 1;
}

}  // namespace freeplay::cli
