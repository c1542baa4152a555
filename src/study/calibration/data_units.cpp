#include "study/calibration/data_units.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace freeplay {

std::string unit_plausibility(const TurnMetrics& measured, const TurnMetrics& ideal) {
  const auto low = [](const TurnMetrics& m) {
    double squares = 0;
    for (std::size_t h = 0; h < std::min<std::size_t>(3, m.spectrum.size()); ++h)
      squares += m.spectrum[h] * m.spectrum[h];
    return std::sqrt(squares);
  };
  const double a = low(measured), b = low(ideal);
  if (!(a > 0 && b > 0)) return "";
  struct Unit {
    const char* name;
    double size;  // m/s²
  };
  for (const auto& unit : {Unit{"g", 9.80665}, {"cm/s²", 0.01}, {"mm/s²", 0.001}})
    if (std::abs(std::log(b / a / unit.size)) < std::log(4.0 / 3))
      return fmt::format(
          "the first three harmonics of the measured acceleration are {:.4g} m/s², those of the ideal "
          "mechanism {:.4g} m/s², {:.3g} times as much; is the file in {} instead of m/s²?",
          a, b, b / a, unit.name);
  return "";
}

}  // namespace freeplay
