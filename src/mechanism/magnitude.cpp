#include "mechanism/magnitude.hpp"

#include <fmt/format.h>

#include <cmath>

namespace freeplay {

std::string beyond_bounds(const Magnitude* bounds, double x, bool greater_than_zero) {
  if (!bounds) return {};
  const bool small = greater_than_zero && x < bounds->least;
  if (!small && std::abs(x) <= bounds->greatest) return {};
  return fmt::format("must be at {} {:.9g}{}{}, is {} ({})", small ? "least" : "most",
                     small ? bounds->least : bounds->greatest, bounds->unit.empty() ? "" : " ", bounds->unit,
                     x, bounds->why);
}

std::string wrong_number(double x, const Range& range, const Magnitude* bounds) {
  if (!std::isfinite(x)) return fmt::format("must be finite, is {}", x);
  if (!range.holds(x)) return fmt::format("must be {}, is {}", range.text, x);
  return beyond_bounds(bounds, x, !range.holds(0) && !range.holds(-1));
}

std::string row_of(const Magnitude& m) {
  return fmt::format("| {} | {} | {:.9g} | {} |\n", m.unit.empty() ? "none" : m.unit,
                     m.least > 0 ? fmt::format("{:.9g}", m.least) : "–", m.greatest, m.why);
}

}  // namespace freeplay
