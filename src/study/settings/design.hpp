// Points in the unit cube, chosen by one of
//
//     random            each coordinate uniform, independently
//     latin-hypercube   of n points each n-th of every coordinate holds one, at a random place in it; which belongs with which is
//                       a random permutation (McKay, Beckman and Conover, Technometrics 21 (1979) 239)
//     sobol             the first n points behind the origin of Sobol's sequence in Gray's order, with the direction numbers of
//                       Joe and Kuo (SIAM J. Sci. Comput. 30 (2008) 2635); nothing is drawn
//
// Equal arguments give equal bits on every machine.
#pragma once

#include <cstdint>
#include <vector>

#include "study/settings/study.hpp"

namespace freeplay {

/// `count` points of `dimensions` coordinates in [0, 1). `seed` does not concern Sobol's.
std::vector<std::vector<double>> unit_points(Draw how, std::size_t dimensions, int count, std::uint64_t seed);

/// A combination of the axes' values that the study asks for.
struct Cell {
  std::vector<double> values;          ///< of each axis, its first key's
  std::vector<std::string> overrides;  ///< KEY=VALUE of every key
};

/// How many there are before study.where leaves some out.
std::size_t unfiltered(const Study& study);

/// Every cell: the points that are drawn, each with every combination of the other axes, the first of them fastest; those that
/// study.where leaves. Throws SceneError where it leaves none.
std::vector<Cell> cells(const Study& study);

}  // namespace freeplay
