// Design of experiments: points in the unit cube and the parameter combinations (cells) of a study.
// The points are chosen by one of
//
// - random: all coordinates uniform and independent
// - latin-hypercube: for n points, each of n equal intervals of every coordinate contains one point
//   at a random position; the intervals are combined by random permutations (McKay, Beckman and
//   Conover, Technometrics 21 (1979) 239)
// - sobol: the first n points after the origin of Sobol's sequence in Gray-code order, with the
//   direction numbers of Joe and Kuo (SIAM J. Sci. Comput. 30 (2008) 2635); deterministic
//
// Equal arguments give equal bits on every machine. The functions keep no state.
#pragma once

#include <cstdint>
#include <vector>

#include "study/settings/study.hpp"

namespace freeplay {

/// `count` points of `dimensions` coordinates in [0, 1). Sobol's sequence ignores `seed`.
std::vector<std::vector<double>> unit_points(DrawMethod how, std::size_t dimensions, int count,
                                             std::uint64_t seed);

/// One combination of the axes' values.
struct Cell {
  std::vector<double> values;          ///< one for each axis: the value of its first key
  std::vector<std::string> overrides;  ///< KEY=VALUE of every key
};

/// Number of cells before study.where excludes some.
std::size_t unfiltered(const Study& study);

/// All cells: each drawn point with every combination of the other axes, the first axis varying
/// fastest, without those that study.where excludes. Throws SceneError if it excludes all.
std::vector<Cell> cells(const Study& study);

}  // namespace freeplay
