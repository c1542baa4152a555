// A gear on the first body and a rack on the second, ideal or with backlash. Another joint guides
// the rack (dynamics/mesh.hpp).
//
//     ideal          one flank stays closed:               one row
//     with backlash  two flanks on opposite sides:         two contacts (dynamics/pairs.hpp)
#pragma once

#include "mechanism/elements/gear_joint.hpp"

namespace freeplay {

/// A gear on a rack, ideal or with backlash.
struct RackJoint {
  static constexpr std::string_view type = "rack";
  std::string name;                            ///< of the element in the scene
  std::array<int, 2> between{ground, ground};  ///< first and second body: indices, or ground
  /// The gear's centre, a point of the rack's pitch line.
  std::array<Vec2, 2> at{Vec2{0, 0}, Vec2{0, 0}};
  /// Unit vector along the rack, in the second body's frame; the gear is on its left.
  Vec2 axis{1, 0};
  double pitch_radius = 0;  ///< m, of the gear
  /// m, spacing of the teeth along the rack divided by π; empty: unknown
  std::optional<double> tooth_module = {};
  double pressure_angle = pressure_angle_20;  ///< rad
  Flank flank = Flank::forward;               ///< of an ideal pair
  /// rad, angle of the gear minus that of the rack at which, at the rack's point, a tooth is
  /// centred in a gap; empty: not in mesh
  std::optional<double> phase = 0;
  std::optional<Backlash> clearance = {};  ///< empty: an ideal joint
  MeshLoss loss = {};                      ///< of an ideal joint

  std::string_view what() const { return clearance ? "a rack" : "a rack without backlash"; }

  static void keys(auto& k, auto& j) {
    k.between("two bodies, or \"ground\" and a body", j.between);
    k.ends("the gear's centre, and a point of the rack's pitch line", j.at);
    k.axis("direction of the rack in the second body's frame; the gear lies on its left", j.axis);
    k.need({"pitch_radius", "m", "of the gear"}, j.pitch_radius, positive);
    k.take({"module", "m", "of the rack's teeth, π times which they are apart"}, j.tooth_module, positive);
    k.take({"pressure_angle", "rad", "of the teeth at the standard distance; if absent: 20 degrees"},
           j.pressure_angle, acute);
    k.choose({"flank", "", "loaded flank of a pair without backlash: "}, j.flank);
    MeshLoss::keys(k, j.loss);
    k.from_bodies(
        {"phase", "rad",
         "angle of the gear relative to the rack at which, opposite the rack's point, its teeth are "
         "centred in the gaps; if absent: as for gears",
         "from the bodies"},
        j.phase);
    if (auto* c = k.group("backlash", j.clearance)) {
      Backlash::keys(k, *c);
      k.check(j.flank == Flank::forward, "flank",
              "applies to pairs without backlash; with backlash either flank is loaded");
    }
    MeshLoss::check(k, j);
  }

  /// Facts of a flank: its side (+1 or −1) and the backlash (m).
  RackFlank mesh(double side, double play) const {
    const double c = std::cos(pressure_angle), s = std::sin(pressure_angle), base = c * pitch_radius;
    RackFlank m{side, axis, c, s, base, 0.5 * play - s * pitch_radius, -base * phase.value_or(0)};
    if (tooth_module) m.period = std::numbers::pi * *tooth_module * c;
    return m;
  }
  /// rad, phase that fits the initial positions of the bodies; empty if they do not mesh
  std::optional<double> phase_of(const Body& one, const Body& two, bool ideal) const {
    const auto m = mesh(side_of(flank), 0);
    const Vec2 d = GearJoint::placed(two, at[1]) - GearJoint::placed(one, at[0]);
    Body turn;
    turn.angle = two.angle;
    const Vec2 A = GearJoint::placed(turn, axis);
    const double below = -dot(perp(A), d);
    if (!(below > 0)) return {};
    double middle = m.cosine * dot(A, d) - m.base * (one.angle.value_or(0) - two.angle.value_or(0));
    if (ideal) middle += m.side * (m.rest + m.sine * below);
    return -middle / m.base;
  }
};

}  // namespace freeplay
