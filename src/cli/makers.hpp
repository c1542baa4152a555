// What commands share: how formulations are made, and where results go by default.
#pragma once

#include <filesystem>

#include "formulations/make.hpp"
#include "sim/run_summary.hpp"
#include "study/case_run.hpp"

namespace freeplay::cli {

/// out/NAME, where NAME is the file's, or its folder's for a file called scene.toml or study.toml.
inline std::filesystem::path default_folder(const std::filesystem::path& file, const std::string& suffix) {
  auto name = file.stem().string();
  if (name == "scene" || name == "study")
    name = std::filesystem::absolute(file).parent_path().filename().string();
  return std::filesystem::path("out") / (name + suffix);
}

/// `matched`: an impact law takes the restitution that the scene's penalty law delivers.
inline MakeFormulation maker(Family family, bool matched = false) {
  return [family, matched](const Scene& scene, const System& system, const State& state) {
    return make(family, scene, system, state,
                matched ? delivered_restitutions(scene, system) : std::vector<double>{});
  };
}

inline Makers makers() {
  return {maker(Family::penalty), maker(Family::nonsmooth), maker(Family::nonsmooth, true)};
}

}  // namespace freeplay::cli
