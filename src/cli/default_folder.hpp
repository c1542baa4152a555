// Where results go by default.
#pragma once

#include <filesystem>
#include <string>

namespace freeplay::cli {

/// out/NAME, where NAME is the file's, or its folder's for a file called scene.toml or study.toml.
inline std::filesystem::path default_folder(const std::filesystem::path& file, const std::string& suffix) {
  auto name = file.stem().string();
  if (name == "scene" || name == "study")
    name = std::filesystem::absolute(file).parent_path().filename().string();
  return std::filesystem::path("out") / (name + suffix);
}

}  // namespace freeplay::cli
