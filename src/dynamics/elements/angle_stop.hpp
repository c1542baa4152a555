// Dynamics of mechanism/elements/angle_stop.hpp, which states the equations.
#pragma once

#include "dynamics/elements/dynamics.hpp"
#include "mechanism/elements/angle_stop.hpp"

namespace freeplay {

template <>
struct Dynamics<AngleStop> : AngleStop {
  void reserve(auto& b) const {
    if (radius) b.reach(*radius);  // the default is no length of the mechanism
  }

  void build(auto& b) const {
    const auto& on = std::get<RevoluteJoint>(b.mechanism().joints[joint]);
    for (const auto& [limit, side] : {std::pair{stop.lower, -1}, std::pair{stop.upper, 1}}) {
      if (!limit) continue;
      auto facts = stop.contact(b, name, on.between, side > 0, arm());
      // There is no sliding on the stop of an ideal joint.
      facts.surface.friction.reset();
      const Vec2 normal =
          direction ? Vec2{side * std::sin(*direction), -side * std::cos(*direction)} : Vec2{};
      b.angle_stop({b.link(on.between, on.at), double(side), *limit, arm(), normal}, facts);
    }
  }
};

}  // namespace freeplay
