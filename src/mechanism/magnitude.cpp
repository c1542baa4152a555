#include "mechanism/magnitude.hpp"

#include <fmt/format.h>

namespace freeplay {

std::string row_of(const Magnitude& m) {
  return fmt::format("| {} | {} | {:.9g} | {} |\n", m.unit.empty() ? "none" : m.unit,
                     m.least > 0 ? fmt::format("{:.9g}", m.least) : "–", m.greatest, m.why);
}

}  // namespace freeplay
