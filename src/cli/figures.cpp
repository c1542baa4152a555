// freeplay figures: draws the figures of a result folder again.
#include <fmt/format.h>

#include <filesystem>

#include "cli/verb.hpp"
#include "io/files/output_file.hpp"
#include "io/files/result_set.hpp"
#include "io/files/run_set.hpp"
#include "mechanism/error.hpp"
#include "plots/drawing/figure.hpp"
#include "plots/drawing/style.hpp"

namespace freeplay::cli {
namespace {

struct FiguresRequest : Request {
  std::string folder;
  std::string style;  ///< preset or file
};

int figures(const FiguresRequest& request) {
  const auto folder = real_folder(request.folder);
  if (!std::filesystem::is_directory(folder)) throw SceneError(request.folder + ": is not a folder");
  if (!request.style.empty()) plots::choose_style(request.style);
  const FolderLock lock(folder, "figures");
  settle_result_sets(folder);
  settle_run(folder);
  const auto made = plots::all(folder);
  if (made.empty())
    throw SceneError(request.folder +
                     ": contains no result files to draw; give a folder made by freeplay run, compare, "
                     "laws, drift or validate");
  for (const auto& path : made) fmt::print("{}\n", path.string());
  return 0;
}

}  // namespace

void figures_verb(Program& program) {
  auto [options, request] = program.verb("figures", "redraw the figures of a result folder", figures);
  options.add("folder", request.folder, "folder made by run, compare, laws, drift or validate").required();
  options.style(request.style);
}

}  // namespace freeplay::cli
