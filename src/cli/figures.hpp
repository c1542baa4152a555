// Figures drawn from completed result files: those of a run by `freeplay run`, those of other verbs, and those of
// published papers with the runs that they need.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "cli/command_line.hpp"
#include "values/stop.hpp"

namespace freeplay {
struct Scene;
}

namespace freeplay::cli {

/// Options of the figures.
struct RunFigures {
  bool none = false;              ///< --no-figures
  std::string style;              ///< --style: preset or file
  std::vector<std::string> plot;  ///< COLUMN[,COLUMN...] over time, one figure each
};

/// Checks the style and the columns before the run. Throws SceneError for an invalid style, and for
/// columns that the run will not have.
void require_figures(const RunFigures& figures, const Scene& scene, const std::string& formulation,
                     const std::filesystem::path& folder);

/// Removes the figures of an earlier run from the folder, draws those of this run, and prints their
/// names. If no figure can be drawn, prints the reason; this is an error only if columns were
/// requested.
void draw_run(const RunFigures& figures, const std::filesystem::path& folder, const StopToken& stop);

/// Draws the figures of a result folder and prints their paths. If they cannot be drawn, prints the reason: the
/// results remain.
void draw_results(const std::filesystem::path& folder);

/// Papers whose figures can be drawn.
std::vector<std::string> papers();

struct PaperRequest {
  std::string paper;   ///< one of papers()
  std::string output;  ///< result folder; empty: out/paper-NAME
  int threads = 0;     ///< 0: all cores
};

/// Makes the missing runs of the paper's study in the result folder and draws the figures by their
/// numbers in the paper. A folder with the results of `validate` is drawn as it is, without runs.
/// Returns the exit status.
int paper_figures(const PaperRequest& request, const Conduct& conduct);

}  // namespace freeplay::cli
