// A command's --document: pages of docs/ with their figures beside them.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "io/input_file.hpp"
#include "io/output_file.hpp"

namespace freeplay::cli {

/// Copies the PNG of each figure into place/figures; their names.
inline std::vector<std::string> copy_figures(const std::vector<std::filesystem::path>& figures,
                                             const std::filesystem::path& place) {
  make_folder(place / "figures");
  std::vector<std::string> names;
  for (auto figure : figures) {
    figure.replace_extension(".png");
    write_file(place / "figures" / figure.filename(), read_file(figure, most_of_a_result));
    names.push_back(figure.filename().string());
  }
  return names;
}

}  // namespace freeplay::cli
