// Hand-made results of studies for tests of their figures: of a paper, an ensemble, a bifurcation
// diagram and a basin.
#pragma once

#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <numbers>
#include <string>

#include "io/files/output_file.hpp"

namespace freeplay::test {

inline nlohmann::json study_origin() {
  return {{"version", "0"}, {"commit", "none"}, {"scene_file", "scene.toml"}, {"scene", ""}};
}

/// Tables of the test matrix of Flores et al. 2011. The position 0.1 m · φ/360° has the velocity
/// 0.1 m · n/60; the acceleration is `size` · n c cos φ.
inline void put_paper_result(const std::filesystem::path& folder, double size) {
  make_folder(folder);
  std::string cells = "variant,formulation,clearance,speed,statistic,mean,low,high\n",
              traces = "variant,formulation,clearance,speed,angle,acceleration,position\n",
              spectra = "variant,formulation,clearance,speed,harmonic,amplitude\n";
  for (const double c : {0.10e-3, 0.25e-3, 0.50e-3, 1.00e-3})
    for (const double n : {100.0, 150.0, 200.0, 250.0})
      for (const char* formulation : {"penalty", "nonsmooth", "ideal"}) {
        const auto head = fmt::format("given,{},{},{}", formulation, c, n);
        if (formulation != std::string("ideal")) {
          for (const char* statistic : {"ratio_95", "peak_95"})
            cells +=
                fmt::format("{},{},{},{},{}\n", head, statistic, 4e3 * size * c + 3, 3, 5e3 * size * c + 5);
          for (int h = 1; h < 5; ++h) spectra += fmt::format("{},{},{}\n", head, h, 10.0 / h);
        }
        for (int angle = 0; angle < 360; angle += 10)
          traces += fmt::format("{},{},{},{}\n", head, angle,
                                size * n * c * std::cos(angle * std::numbers::pi / 180), 0.1 * angle / 360);
      }
  write_file(folder / "paper.json", nlohmann::json{{"provenance", study_origin()}}.dump());
  write_file(folder / "cells.csv", cells);
  write_file(folder / "traces.csv", traces);
  write_file(folder / "spectra.csv", spectra);
}

/// Bands of a velocity and of a gap of micrometres, and statistics of eight starts.
inline void put_ensemble(const std::filesystem::path& folder) {
  make_folder(folder);
  std::string bands = "column,t,q05,q25,q50,q75,q95\n";
  for (const auto& [column, size] : {std::pair("slider.vx", 1.2), {"gudgeon.gap", 9e-5}})
    for (int i = 0; i <= 60; ++i) {
      const double v = std::sin(0.2 * i);
      bands += fmt::format("{},{}", column, 0.01 * i);
      for (const double q : {-0.2, -0.1, 0.0, 0.1, 0.2}) bands += fmt::format(",{}", size * (v + q));
      bands += "\n";
    }
  std::string starts = "start,finished,gudgeon.fastest_approach_m_per_s,gudgeon.impacts\n";
  for (int k = 0; k < 8; ++k) starts += fmt::format("{},1,{},{}\n", k, 0.032 + 0.008 * k * k, 20 + 3 * k);
  write_file(folder / "ensemble.json", nlohmann::json{{"provenance", study_origin()}}.dump());
  write_file(folder / "bands.csv", bands);
  write_file(folder / "starts.csv", starts);
}

inline nlohmann::json study_axis(const char* name, const char* unit) {
  return {{"name", name}, {"key", "k"}, {"unit", unit}, {"scale", 1.0}};
}

inline void put_bifurcation(const std::filesystem::path& folder) {
  make_folder(folder);
  std::string points = "branch,value,attractor,period,t,gudgeon.ex_c,approach\n";
  for (int i = 0; i < 9; ++i)
    for (const char* branch : {"up", "down", "random"})
      points += fmt::format("{},{},0,1,1,{},{}\n", branch, 0.05 * (i + 1), i == 4 ? NAN : 0.94 + 0.007 * i,
                            0.0012 * i);
  write_file(folder / "bifurcation.csv", points);
  write_file(
      folder / "bifurcation.json",
      nlohmann::json{
          {"provenance", study_origin()},
          {"bifurcation",
           {{"columns", {{{"name", "gudgeon.ex_c"}, {"unit", ""}}, {{"name", "approach"}, {"unit", "m/s"}}}},
            {"axis", study_axis("clearance", "mm")}}}}
          .dump());
}

inline void put_basin(const std::filesystem::path& folder) {
  make_folder(folder);
  std::string cells = "x,y,attractor,period,axle.angle\n";
  for (int i = 0; i < 20; ++i)
    for (int j = 0; j < 12; ++j)
      cells += fmt::format("{},{},{},1,{}\n", -0.95 + 0.1 * i, -6 + j, i > j ? 1 : 0, i > j ? 1 : -1);
  const auto attractor = [](const char* cycle) {
    return nlohmann::json{{"kind", "period 1"}, {"cycle", cycle}};
  };
  write_file(folder / "basin.csv", cells);
  write_file(
      folder / "basin.json",
      nlohmann::json{{"provenance", study_origin()},
                     {"basin",
                      {{"columns", {{{"name", "axle.angle"}, {"unit", "rad"}}}},
                       {"attractors", {attractor("axle.angle = -1 rad"), attractor("axle.angle = 1 rad")}},
                       {"x", study_axis("angle", "rad")},
                       {"y", study_axis("speed", "rad/s")}}}}
          .dump());
}

}  // namespace freeplay::test
