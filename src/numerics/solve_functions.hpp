// Compiled functions of a SaddlePoint (saddle_trace.cpp), for mechanisms whose blocks all have few
// rows. With the values of G in force and the factors F,
//
//     factor:   in G            out F, pivot ratios       fails for small pivots: use the general path
//     solve:    in F, G, f, r   out a, λ
//     respond:  in F, G, f      out a, λ                  r = 0
//
// The operations and their order are those of the general path.
#pragma once

#include <vector>

#include "numerics/trace.hpp"

namespace freeplay {

struct SolveFunctions {
  CompiledFunction factor = nullptr, solve = nullptr, respond = nullptr;
  const double* constants = nullptr;
  bool eliminate = true;    ///< RowFacts::eliminate of the traced SaddlePoint
  int factors = 0;          ///< entries of F
  std::vector<int> ratios;  ///< number of pivot ratios of each block
};

}  // namespace freeplay
