// Reads columns of a trajectory in one pass, thinned for paper: if there are more rows than a curve
// needs, every n-th row.
#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "plots/tables/run_facts.hpp"

namespace freeplay::plots {

struct RunTable {
  std::vector<std::string> bodies;  ///< in the order of the file
  std::vector<double> t;
  /// [body][x, y, theta, vx, vy, omega][row]
  std::vector<std::array<std::vector<double>, 6>> motion;
};

/// The motion of the first bodies of a run within a time span. About `rows` rows are kept.
RunTable motion_of(const std::filesystem::path& run, const Span& span, std::size_t most_bodies, long rows);

/// Difference of greatest and least value.
double range_of(const std::vector<double>& values);

}  // namespace freeplay::plots
