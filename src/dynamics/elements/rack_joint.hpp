// Dynamics of mechanism/elements/rack_joint.hpp, which states the equations.
#pragma once

#include "dynamics/elements/gear_joint.hpp"
#include "dynamics/mesh.hpp"
#include "dynamics/rows/spin.hpp"
#include "mechanism/elements/rack_joint.hpp"

namespace freeplay {

template <>
struct Dynamics<RackJoint> : RackJoint {
  void build(auto& b) const {
    if (!phase) return;
    if (between[0] != ground) b.reach(pitch_radius);
    const auto rub = [&](const auto& link, const auto& c) {
      // As for gears, but u is the rotation of the second body against the first, the gear.
      const bool drives = flank == Flank::backward;
      const double base = std::cos(pressure_angle) * pitch_radius;
      b.friction(SpinRow{link, base}, {name, 0, speed_at(loss.regularisation, base),
                                       b.mesh_bound(drives ? c[0] : c[1], drives ? c[1] : c[0])});
    };
    build_teeth<RackMesh>(b, *this, std::sin(pressure_angle) * pitch_radius, rub);
  }
};

}  // namespace freeplay
