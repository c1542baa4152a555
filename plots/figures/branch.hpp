// Titles and looks of the kinds of bifurcations in the figures `branch` and `curves`.
#pragma once

#include "plots/drawing/figure.hpp"

namespace freeplay::plots {

struct BifurcationLook {
  const char* kind;  ///< in bifurcations.csv
  const char* title;
  Word mark;  ///< of a point
  Word line;  ///< of a curve over two keys; empty: there is none
};
inline constexpr BifurcationLook bifurcation_looks[] = {
    {"fold", "fold", "pt 9 ps 1.0 lc rgb C4", "lw 2 lc rgb C4"},
    {"flip", "period doubling", "pt 7 ps 0.9 lc rgb C5", "lw 2 dt (8,3) lc rgb C5"},
    {"torus", "torus", "pt 5 ps 0.9 lc rgb C6", "lw 2 dt (2,3) lc rgb C6"},
    {"grazing", "grazing impact", "pt 2 ps 1.0 lw 2 lc rgb C7", "lw 2 dt (8,3,2,3) lc rgb C7"},
    {"liftoff", "lift-off", "pt 13 ps 1.1 lc rgb C8", "lw 2.4 lc rgb C8"},
    {"sequence", "other sequence", "pt 11 ps 1.0 lc rgb C9", ""}};

}  // namespace freeplay::plots
