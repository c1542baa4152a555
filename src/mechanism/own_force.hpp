// An applied force from outside the program: of a compiled plugin, or of a function of the caller's. It stands in place of what a load
// of type "force" says. No scene names one: whoever gives the scene to the program adds it, and the provenance tells of it.
#pragma once

#include <array>
#include <cmath>
#include <memory>
#include <string>

#include "numerics/dual.hpp"
#include "values/vec2.hpp"

namespace freeplay {

struct OwnForce {
  /// N, along the load's `axes`, on the load of this name at t (s), the loaded point's place (m) and velocity (m/s), both in the
  /// world. Called from one thread at a time. What it throws leaves the run.
  Vec2 (*force)(const void* context, const char* load, double t, const Vec2& place,
                const Vec2& velocity) = nullptr;
  std::shared_ptr<const void> context = {};
  std::string name;    ///< for people, on one line: "gas.so"
  std::string digest;  ///< of what it was made from (io/files/digest.hpp), in the identity of a run

  Vec2 at(const std::string& load, double t, const Vec2& place, const Vec2& velocity) const {
    return force(context.get(), load.c_str(), t, place, velocity);
  }
  /// With derivatives by central differences: steps of ∛ε of the size of what is changed leave errors of ∛ε².
  template <int N>
  Vec2Of<Dual<N>> at(const std::string& load, const Dual<N>& t, const Vec2Of<Dual<N>>& place,
                     const Vec2Of<Dual<N>>& velocity) const {
    std::array<double, 5> x{t.value, place.x().value, place.y().value, velocity.x().value,
                            velocity.y().value};
    const std::array<const Dual<N>*, 5> of{&t, &place.x(), &place.y(), &velocity.x(), &velocity.y()};
    const auto value = [&] { return at(load, x[0], {x[1], x[2]}, {x[3], x[4]}); };
    const Vec2 f = value();
    Vec2Of<Dual<N>> r{Dual<N>(f.x()), Dual<N>(f.y())};
    for (std::size_t i = 0; i < x.size(); ++i) {
      if (of[i]->slope == std::array<double, N>{}) continue;
      const double here = x[i], h = 6e-6 * std::fmax(std::abs(here), 1e-3);
      x[i] = here + h;
      const Vec2 above = value();
      x[i] = here - h;
      const Vec2 rise = above - value();
      x[i] = here;
      for (int n = 0; n < N; ++n) {
        r.x().slope[n] += rise.x() / (2 * h) * of[i]->slope[n];
        r.y().slope[n] += rise.y() / (2 * h) * of[i]->slope[n];
      }
    }
    return r;
  }
};

}  // namespace freeplay
