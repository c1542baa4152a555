// A command's --document: pages of docs/ with their figures beside them.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "io/files/folder_lock.hpp"
#include "io/files/input_file.hpp"
#include "io/files/output_file.hpp"

namespace freeplay::cli {

/// Makes the folder of a document and takes the right to write into it, unless it is the command's `own`, which has it.
inline std::unique_ptr<FolderLock> lock_document(const std::filesystem::path& place,
                                                 const std::filesystem::path& own, std::string_view verb) {
  make_folder(place);
  if (std::filesystem::equivalent(place, own)) return nullptr;
  return std::make_unique<FolderLock>(place, verb);
}

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
