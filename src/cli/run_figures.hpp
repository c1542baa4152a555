// The figures that `freeplay run` draws of its result files, when these are in their places.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "values/stop.hpp"

namespace freeplay {
struct Scene;
}

namespace freeplay::cli {

struct RunFigures {
  bool none = false;              ///< --no-figures
  std::vector<std::string> plot;  ///< COLUMN[,COLUMN...] over time, a figure each
};

/// Throws SceneError for a style that is wrong and for columns that the run will not have, before it is made.
void require_figures(const RunFigures& figures, const Scene& scene, const std::string& formulation,
                     const std::filesystem::path& folder);

/// Removes the figures of an earlier run in the folder and draws those of this one; says what it drew. That none can be
/// drawn is said too, and is no failure of the run unless columns were asked for.
void draw_run(const RunFigures& figures, const std::filesystem::path& folder, const StopToken& stop);

}  // namespace freeplay::cli
