// Helpers for second derivations of forces: numerical derivatives in long double, and their error
// bounds.
#pragma once

#include <cmath>
#include <random>
#include <string>

#include "verification/references/planar.hpp"
#include "verification/unit/references/reference_checks.hpp"

namespace freeplay::reference::derived {

using Vec = Planar<Long>;

/// Central differences of the steps h, h/2, … h/32, extrapolated to zero (Richardson).
///
/// Truncation: with R the distance of the nearest singularity in the complex plane, (h/R)¹² 2⁻³⁰ of
/// f/R. The tests keep h/R ≤ 0.2/1.1, which leaves 1.2e-18. Rounding: an error η of a value causes
/// 2 η/(h/32), the 2 from the weights of the extrapolation, so 315 η at h = 0.2. Positions of the
/// size l are known to 3e-19 l (arguments up to π and a handful of operations, ε/2 = 5e-20), first
/// derivatives therefore to 1e-16 l, second to 3e-14 l.
template <class Function>
Long richardson(const Function& f, Long t, Long h = 0.2L) {
  constexpr int levels = 6;
  Long row[levels];
  for (int i = 0; i < levels; ++i, h /= 2) {
    row[i] = (f(t + h) - f(t - h)) / (2 * h);
    Long four = 1;
    for (int j = i - 1; j >= 0; --j) {
      four *= 4;
      row[j] = row[j + 1] + (row[j + 1] - row[j]) / (four - 1);
    }
  }
  return row[0];
}

template <class Function>
Vec richardson_vector(const Function& f, Long t, Long h = 0.2L) {
  return {richardson([&](Long s) { return f(s).x; }, t, h), richardson([&](Long s) { return f(s).y; }, t, h)};
}

inline const Long once = 1e-15L;
inline const char* const why_once = "one Richardson derivative: 1e-16 of the scale, several terms";
inline const Long twice = 3e-14L;
inline const char* const why_twice = "two Richardson derivatives: 3e-14 of the scale";
inline const Long combined = 4e-13L;
inline const char* const why_combined = "3e-14 of the scale, five terms, divided by x ≥ 0.4 l";

inline void within(const Vec& measured, const Vec& expected, Long bound, const std::string& why) {
  freeplay::reference::within(measured.x, expected.x, bound, "x: " + why);
  freeplay::reference::within(measured.y, expected.y, bound, "y: " + why);
}
using freeplay::reference::within;

inline Long size(const Vec& a) { return std::hypot(a.x, a.y); }

class Draw {
 public:
  explicit Draw(unsigned seed) : generator_(seed) {}
  Long between(Long a, Long b) {
    return a + (b - a) * std::uniform_real_distribution<Long>(0, 1)(generator_);
  }
  Vec vector(Long most) {
    const Long x = between(-most, most);
    return {x, between(-most, most)};
  }

 private:
  std::mt19937 generator_;
};

}  // namespace freeplay::reference::derived
