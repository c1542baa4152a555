// The looks of many curves in one figure. The first nine have the colours C1 to C9 of the style, each with
// its own mark; the next nine have the same colours with other marks and dash patterns, and so on. Colour
// and mark together repeat after 81 curves. Readers who do not see the colours, and monochrome figures,
// have mark and dash pattern.
#pragma once

#include <array>
#include <cstddef>

#include "plots/drawing/gnuplot.hpp"

namespace freeplay::plots {

inline constexpr std::size_t curve_colours = 9;  ///< C1 … C9 of every script

struct NumberedLook {
  std::size_t colour;  ///< of C1 … C9
  Word mark, dash;     ///< pt and dt of gnuplot
};

/// The look of curve n = 0, 1 …; `broken`: of a second curve of the same colour and mark, such as that of
/// the penalty formulation.
constexpr NumberedLook curve_look(std::size_t n, bool broken) {
  constexpr std::array<Word, curve_colours> marks{"7", "5", "9", "13", "11", "6", "4", "8", "12"};
  constexpr std::array<std::array<Word, 2>, 3> dashes{
      {{"1", "2"}, {"(14,4,3,4)", "(3,4)"}, {"(6,4)", "(1,3)"}}};
  const std::size_t round = n / curve_colours;
  // 4 and 9 have no common divisor: no colour meets a mark again before all nine.
  return {n % curve_colours + 1, marks[(n + 4 * round) % marks.size()], dashes[round % 3][broken ? 1 : 0]};
}

}  // namespace freeplay::plots
