// A figure of any columns of one run or several: panels one above the other, a curve for each column and run.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "plots/drawing/style.hpp"
#include "plots/tables/columns.hpp"

namespace freeplay::plots {

struct ColumnPlot {
  std::vector<std::filesystem::path> folders;  ///< of runs or comparisons; the figure goes to the first
  std::string x = "t";
  std::vector<std::vector<std::string>>
      panels;                                ///< columns; those of different units get panels of their own
  std::optional<double> from = {}, to = {};  ///< s
  std::optional<Crossing> section = {};
  std::string name = {};             ///< of its files; empty: by its columns
  std::vector<Format> formats = {};  ///< empty: the style's
};

/// The path of its first format. Throws SceneError for columns that there are not.
std::filesystem::path draw_columns(const ColumnPlot& plot);

/// COLUMN=VALUE, with :up or :down behind it. Throws SceneError.
Crossing crossing_of(const std::string& text);

/// Fewer points of a curve that look the same on paper: of each stretch of a curve over time its first, last, least and
/// greatest; of others every so-manieth.
Points thinned(const Points& points, std::size_t most);

}  // namespace freeplay::plots
