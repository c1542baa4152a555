#include "mechanism/magnitude.hpp"

#include <fmt/format.h>

#include <cmath>

namespace freeplay {

std::string beyond_bounds(const Magnitude* bounds, double x, bool greater_than_zero,
                          const std::string& stated) {
  if (!bounds) return {};
  const bool small = greater_than_zero && x < bounds->least;
  if (!small && std::abs(x) <= bounds->greatest) return {};
  return fmt::format("must be at {} {:.9g}{}{}, is {} ({})", small ? "least" : "most",
                     small ? bounds->least : bounds->greatest, bounds->unit.empty() ? "" : " ", bounds->unit,
                     stated.empty() ? fmt::format("{}", x) : stated, bounds->why);
}

std::string wrong_number(double x, const Range& range, const Magnitude* bounds, const std::string& stated) {
  const auto is = stated.empty() ? fmt::format("{}", x) : stated;
  if (!std::isfinite(x)) return fmt::format("must be finite, is {}", is);
  if (!range.holds(x)) return fmt::format("must be {}, is {}", range.text, is);
  return beyond_bounds(bounds, x, !range.holds(0) && !range.holds(-1), stated);
}

std::string row_of(const Magnitude& m) {
  return fmt::format("| {} | {} | {:.9g} | {} |\n", m.unit.empty() ? "none" : m.unit,
                     m.least > 0 ? fmt::format("{:.9g}", m.least) : "–", m.greatest, m.why);
}

}  // namespace freeplay
