// External contact of two discs: one contact (dynamics/pairs.hpp).
#pragma once

#include <array>
#include <string>

#include "mechanism/body.hpp"

namespace freeplay {

/// External contact of two discs.
struct DiscContact {
  static constexpr std::string_view type = "discs";
  std::string name;                                ///< of the element in the scene
  std::array<int, 2> between{ground, ground};      ///< first and second body: indices, or ground
  std::array<Vec2, 2> at{Vec2{0, 0}, Vec2{0, 0}};  ///< centres
  std::array<double, 2> radii{0, 0};               ///< m, > 0
  int surface = -1;                                ///< index into Mechanism::surfaces

  std::string_view what() const { return "a contact of discs"; }

  static void keys(auto& k, auto& c) {
    k.between("two bodies, or \"ground\" and a body; a plane is on the first", c.between);
    k.ends("their centres", c.at);
    k.radii({"radii", "m", "both radii, of external contact"}, c.radii);
    k.surface({"surface", "", "the surface of the contact"}, c.surface);
  }
};

}  // namespace freeplay
