// Default folders of results.
#pragma once

#include <filesystem>
#include <string>

#include "io/files/output_file.hpp"

namespace freeplay::cli {

/// out/NAME, with the name of the file, or of its folder for a file called scene.toml or
/// study.toml.
inline std::filesystem::path default_folder(const std::filesystem::path& file, const std::string& suffix) {
  auto name = file.stem().string();
  if (name == "scene" || name == "study")
    name = std::filesystem::absolute(file).lexically_normal().parent_path().filename().string();
  return std::filesystem::path("out") / (name + suffix);
}

/// The folder given by -o, or the default. Symbolic links in the path are the user's and are
/// resolved here; output below the folder follows no link.
inline std::filesystem::path result_folder(const std::string& requested,
                                           const std::filesystem::path& otherwise) {
  return real_folder(requested.empty() ? otherwise : std::filesystem::path(requested));
}

}  // namespace freeplay::cli
