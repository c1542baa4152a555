// Figures of chosen quantities of a study's results: curves over one axis of a sweep with 95 %
// intervals over the starts, heat maps over two axes; bands and histograms of an ensemble; columns
// of a bifurcation diagram and of a basin.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "plots/drawing/style.hpp"

namespace freeplay::plots {

struct StudyPlot {
  std::filesystem::path folder;  ///< results of sweep, ensemble, bifurcation or basin
  std::vector<std::string> y;    ///< measures, statistics or columns
  std::vector<std::string> x;    ///< one axis of a sweep for curves, two for a map; may be empty
  std::string name = {};         ///< of the files; empty: derived from the above
  std::string title = {};        ///< above the panels; empty: none
  std::vector<Format> formats = {};
};

/// Whether the folder has the results of one of these commands.
bool holds_study_results(const std::filesystem::path& folder);

/// Draws the figure and returns the path of its first format. Throws SceneError, which lists the
/// names that are available, for an unknown one.
std::filesystem::path draw_study(const StudyPlot& plot);

/// The same for one kind of results.
std::filesystem::path draw_sweep(const StudyPlot& plot);
std::filesystem::path draw_ensemble_of(const StudyPlot& plot);
std::filesystem::path draw_bifurcation_of(const StudyPlot& plot);
std::filesystem::path draw_basin_of(const StudyPlot& plot);

/// Name of the figure's files: the given one, or KIND_Y-Y.
std::string name_of_plot(const StudyPlot& plot, const char* kind, const std::string& more = "");

}  // namespace freeplay::plots
