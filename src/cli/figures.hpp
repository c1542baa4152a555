// Figures drawn from completed result files: those of a run by `freeplay run`, and those of other verbs.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

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

/// If figures cannot be drawn: prints the reason, as the results remain, or fails.
enum class Undrawn { is_reported, is_error };
/// Prints the path of a result folder, draws its figures and prints their paths.
void draw_results(const std::filesystem::path& folder, Undrawn undrawn, const StopToken& stop = {});

}  // namespace freeplay::cli
