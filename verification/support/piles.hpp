// Piles of discs between walls, as scenes in TOML, shared by tests and claims.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <vector>
#include "verification/support/scene_text.hpp"

namespace freeplay::test {

struct Disc {
  double x, y, R;
};

/// Discs of density 50 kg/m² between a floor and walls at 0 and `width` that are inclined outwards
/// by `lean`, in TOML.
inline std::string pile(const std::vector<Disc>& discs, double width, double lean, double mu, double e,
                        double duration, std::mt19937* random = nullptr) {
  std::uniform_real_distribution<double> u(-0.5, 0.5);
  std::string text = "gravity = [0.0, -9.81]\n";
  for (std::size_t i = 0; i < discs.size(); ++i) {
    const auto& d = discs[i];
    const double m = 50 * M_PI * d.R * d.R;
    text += fmt::format("[bodies.d{}]\nmass = {}\ninertia = {}\nposition = [{}, {}]\n", i, m,
                        0.5 * m * d.R * d.R, d.x, d.y);
    if (random) text += fmt::format("velocity = [{}, {}]\n", u(*random), u(*random));
  }
  const auto wall = [&](const char* name, std::size_t i, double x, double ax, double ay) {
    text += test::plane(fmt::format("{}{}", name, i), "ground", fmt::format("d{}", i), discs[i].R, "s",
                        fmt::format("at = [[{}, 0.0], [0.0, 0.0]]\naxis = [{}, {}]\n", x, ax, ay));
  };
  for (std::size_t i = 0; i < discs.size(); ++i) {
    wall("floor", i, 0, 1, 0);
    wall("left", i, 0, std::sin(lean), -std::cos(lean));
    wall("right", i, width, std::sin(lean), std::cos(lean));
    for (std::size_t j = 0; j < i; ++j)
      text += fmt::format(
          "[contacts.c{}_{}]\ntype = \"discs\"\nbetween = [\"d{}\", \"d{}\"]\nradii = [{}, {}]\n"
          "surface = \"s\"\n",
          j, i, j, i, discs[j].R, discs[i].R);
  }
  return text + test::surface("s", e, mu) + test::run_for(duration, "start = \"given\"\n");
}

inline std::string random_pile(unsigned seed) {
  std::mt19937 random(seed);
  const auto u = [&](double lo, double hi) { return std::uniform_real_distribution<double>(lo, hi)(random); };
  std::vector<Disc> discs;
  const double width = u(0.3, 0.4);
  for (int i = 0; i < 4 + static_cast<int>(seed % 3); ++i) {
    Disc d{0, 0, u(0.02, 0.05)};
    for (double lift = 0;; lift += 1e-3) {
      d.x = u(1.02 * d.R, width - 1.02 * d.R);
      d.y = 1.02 * d.R + lift;
      if (std::ranges::all_of(
              discs, [&](const Disc& o) { return std::hypot(o.x - d.x, o.y - d.y) > 1.03 * (o.R + d.R); }))
        break;
    }
    discs.push_back(d);
  }
  const double mu = u(0, 0.3), e = u(0.1, 0.6);
  return pile(discs, width, 0, mu, e, 0.3, &random);
}

}  // namespace freeplay::test
