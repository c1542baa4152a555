// A command's --document: pages of docs/ with their figures beside them.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "io/output_file.hpp"

namespace freeplay::cli {

/// Copies the PNG of each figure into place/figures; their names.
inline std::vector<std::string> copy_figures(const std::vector<std::filesystem::path>& figures,
                                             const std::filesystem::path& place) {
  make_folder(place / "figures");
  std::vector<std::string> names;
  for (auto figure : figures) {
    figure.replace_extension(".png");
    std::filesystem::copy_file(figure, place / "figures" / figure.filename(),
                               std::filesystem::copy_options::overwrite_existing);
    names.push_back(figure.filename().string());
  }
  return names;
}

}  // namespace freeplay::cli
