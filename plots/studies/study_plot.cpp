#include "plots/studies/study_plot.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "mechanism/error.hpp"
#include "plots/drawing/figure.hpp"

namespace freeplay::plots {
namespace {

struct StudyKind {
  const char* file;  ///< marks the results
  std::filesystem::path (*draw)(const StudyPlot&);
};
constexpr StudyKind study_kinds[] = {{"sweep.db", draw_sweep},
                                     {"ensemble.json", draw_ensemble_of},
                                     {"bifurcation.json", draw_bifurcation_of},
                                     {"basin.json", draw_basin_of}};

const StudyKind* kind_of_study(const std::filesystem::path& folder) {
  const auto* it = std::ranges::find_if(
      study_kinds, [&](const StudyKind& kind) { return std::filesystem::exists(folder / kind.file); });
  return it == std::end(study_kinds) ? nullptr : it;
}

}  // namespace

bool holds_study_results(const std::filesystem::path& folder) { return kind_of_study(folder) != nullptr; }

std::filesystem::path draw_study(const StudyPlot& plot) {
  const auto* kind = kind_of_study(plot.folder);
  if (!kind)
    throw SceneError(plot.folder.string() +
                     ": has no results of freeplay sweep, ensemble, bifurcation or basin");
  return kind->draw(plot);
}

std::string name_of_plot(const StudyPlot& plot, const char* kind, const std::string& more) {
  if (!plot.name.empty()) return plot.name;
  return file_name(kind, fmt::format("{}{}", fmt::join(plot.y, "-"), more));
}

}  // namespace freeplay::plots
