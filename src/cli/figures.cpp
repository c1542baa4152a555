// freeplay figures: draws the figures of a result folder again, or those of a published paper.
#include <fmt/format.h>

#include <filesystem>

#include "cli/paper_figures.hpp"
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
  PaperRequest paper;
  std::string style;  ///< preset or file
};

int figures(const FiguresRequest& request) {
  if (!request.style.empty()) plots::choose_style(request.style);
  if (!request.paper.paper.empty()) return paper_figures(request.paper, request.conduct());
  if (request.folder.empty())
    throw SceneError(
        fmt::format("figures: needs a result folder to draw, or --paper {} for the figures of a paper",
                    papers().front()));
  const auto folder = real_folder(request.folder);
  if (!std::filesystem::is_directory(folder)) throw SceneError(request.folder + ": is not a folder");
  const FolderLock lock(folder, "figures");
  settle_result_sets(folder);
  settle_run(folder);
  const auto made = plots::all(folder);
  if (made.empty())
    throw SceneError(request.folder +
                     ": contains no result files to draw; give a folder made by freeplay run, compare, "
                     "orbit, continue, lyapunov, laws, drift or validate");
  for (const auto& path : made) fmt::print("{}\n", path.string());
  return 0;
}

}  // namespace

void figures_verb(Program& program) {
  auto [options, request] =
      program.verb("figures", "redraw the figures of a result folder, or draw those of a paper", figures);
  auto folder =
      options.add("folder", request.folder,
                  "folder made by run, compare, orbit, continue, lyapunov, laws, drift or validate");
  auto paper = options
                   .add("--paper", request.paper.paper,
                        "draw the figures of this paper by their numbers; makes the runs that are missing")
                   .one_of(papers())
                   .excludes(folder);
  options.output(request.paper.output, "result folder of --paper; default out/paper-PAPER").needs(paper);
  options.threads(request.paper.threads).needs(paper);
  options.style(request.style);
}

}  // namespace freeplay::cli
