// Checks shared by the tests of the references.
#pragma once

#include <catch2/catch.hpp>
#include <cmath>
#include <string>

namespace freeplay::reference {

using Long = long double;
inline const double pi = std::acos(-1.0);

inline void within(Long measured, Long expected, Long bound, const std::string& why) {
  INFO("measured " << measured << ", expected " << expected << ", bound " << bound << ": " << why);
  CHECK(std::abs(measured - expected) <= bound);
}

/// Fourth-order central difference.
template <class Function>
Long slope(Function f, Long t, Long h) {
  return (8 * (f(t + h) - f(t - h)) - (f(t + 2 * h) - f(t - 2 * h))) / (12 * h);
}

inline const char* const rounding = "a few dozen roundings of quantities of order one in double";

}  // namespace freeplay::reference
