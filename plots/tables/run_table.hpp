// Columns of a trajectory together, in one pass, thinned out for paper: of more rows than a curve needs every so-manieth.
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

/// The motion of the first bodies of a run within a span; `rows` is about how many rows are kept.
RunTable motion_of(const std::filesystem::path& run, const Span& span, std::size_t most_bodies, long rows);

/// Greatest less least value.
double range_of(const std::vector<double>& values);

}  // namespace freeplay::plots
