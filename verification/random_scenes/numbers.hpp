// Numbers of random scenes: drawn from a seed, and rounded to the 12 digits of a scene's text.
#pragma once

#include <fmt/format.h>

#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <numbers>
#include <random>
#include <string>
#include <type_traits>

#include "values/vec2.hpp"

namespace freeplay::verification::random_scenes {

inline std::string text_of(double x) { return fmt::format("{:.12g}", x); }
/// A number as the text has it: scene and reference use the same.
inline double exact(double x) { return std::strtod(text_of(x).c_str(), nullptr); }

inline std::string text_of(Vec2 p) { return fmt::format("[{}, {}]", text_of(p.x()), text_of(p.y())); }

/// A scene's text by a format, in which ' stands for "; numbers and points have 12 digits.
template <class... X>
std::string toml(std::string format, const X&... x) {
  for (auto& c : format)
    if (c == '\'') c = '"';
  const auto shown = [](const auto& one) {
    using One = std::decay_t<decltype(one)>;
    if constexpr (std::is_same_v<One, double> || std::is_same_v<One, Vec2>)
      return text_of(one);
    else
      return one;
  };
  return fmt::format(fmt::runtime(format), shown(x)...);
}

/// Numbers determined by a seed and an index alone. The standard does not fix its distributions, so
/// these are separate ones.
class Draw {
 public:
  Draw(std::uint64_t seed, std::uint64_t index) : engine_(seed + 0x9e3779b97f4a7c15u * (index + 1)) {
    engine_.discard(8);
  }
  /// Uniform in [0, 1).
  double operator()() { return static_cast<double>(engine_() >> 11) * 0x1p-53; }
  double between(double low, double high) { return low + (high - low) * (*this)(); }
  /// 10 to a uniform power.
  double decades(double low, double high) { return std::pow(10, between(low, high)); }
  double either_way(double size) { return between(-size, size); }
  double sign() { return (*this)() < 0.5 ? -1 : 1; }
  double angle() { return between(-std::numbers::pi, std::numbers::pi); }
  /// From low to high, both included.
  int whole(int low, int high) { return low + static_cast<int>((*this)() * (high - low + 1)); }
  bool chance(double share) { return (*this)() < share; }
  /// In any direction.
  Vec2 along(double length) {
    const double a = angle();
    return {length * std::cos(a), length * std::sin(a)};
  }

 private:
  std::mt19937_64 engine_;
};

}  // namespace freeplay::verification::random_scenes
