// Dynamics of mechanism/elements/travel_stop.hpp, which states the equations.
#pragma once

#include "dynamics/elements/dynamics.hpp"
#include "mechanism/elements/travel_stop.hpp"

namespace freeplay {

template <>
struct Dynamics<TravelStop> : TravelStop {
  void build(auto& b) const {
    std::visit([&](const auto& on) { build_on(b, on); }, b.mechanism().joints[joint]);
  }

 private:
  void build_on(auto& b, const auto& on) const {
    if constexpr (requires { on.clearance->half_play; }) {
      double size = b.longest_arm(), pin = 0;
      if (stop.lower && stop.upper) size = std::max(size, *stop.upper - *stop.lower);
      if constexpr (requires { on.clearance->pin_radius; })
        if (on.clearance) pin = on.clearance->pin_radius;
      for (const auto& [limit, side] : {std::pair{stop.lower, 1}, std::pair{stop.upper, -1}}) {
        if (!limit) continue;
        auto facts = stop.contact(b, name, on.between, side < 0, size);
        // There is no sliding on the stop of an ideal joint.
        if (!on.clearance) facts.surface.friction.reset();
        b.line(b.link(on.between, on.at), side, -perp(on.axis), side * *limit, pin, facts);
      }
    }
  }
};

}  // namespace freeplay
