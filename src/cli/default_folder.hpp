// Where results go by default.
#pragma once

#include <filesystem>
#include <string>

#include "io/files/output_file.hpp"

namespace freeplay::cli {

/// out/NAME, where NAME is the file's, or its folder's for a file called scene.toml or study.toml.
inline std::filesystem::path default_folder(const std::filesystem::path& file, const std::string& suffix) {
  auto name = file.stem().string();
  if (name == "scene" || name == "study")
    name = std::filesystem::absolute(file).lexically_normal().parent_path().filename().string();
  return std::filesystem::path("out") / (name + suffix);
}

/// The folder that -o names, or the default. Links on the way to it are the user's own and are followed here; what is
/// written below it follows none.
inline std::filesystem::path result_folder(const std::string& asked, const std::filesystem::path& otherwise) {
  return real_folder(asked.empty() ? otherwise : std::filesystem::path(asked));
}

}  // namespace freeplay::cli
