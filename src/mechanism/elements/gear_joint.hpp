// A pair of gears with involute teeth, ideal or with backlash. Other joints hold their centres,
// which may move (dynamics/mesh.hpp).
//
//     ideal          one flank stays closed:               one row
//     with backlash  two flanks on opposite sides:         two contacts (dynamics/pairs.hpp)
#pragma once

#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <string>

#include "mechanism/body.hpp"
#include "mechanism/mesh.hpp"
#include "mechanism/mesh_loss.hpp"

namespace freeplay {

/// The flank that carries in an ideal pair.
enum class Flank { forward, backward };
inline constexpr auto flank_names =
    complete<Flank>({{Flank::forward, "forward", "the first pushes the second counter-clockwise"},
                     {Flank::backward, "backward", "turning clockwise"}});
constexpr std::span<const Choice<Flank>> choices(Flank) { return flank_names; }
/// +1 for the forward flank, −1 for the backward one.
constexpr double side_of(Flank flank) { return flank == Flank::forward ? 1 : -1; }

/// Backlash of a pair of teeth.
struct Backlash {
  double normal = 0;  ///< m, > 0, clearance along the line of action at the standard distance
  std::optional<double> stiffness = {};  ///< N/m, > 0, of the mesh along the line of action
  int surface = -1;                      ///< index into Mechanism::surfaces

  static void keys(auto& k, auto& b) {
    k.need({"backlash", "m", "backlash along the line of action, at the standard distance; if absent: ideal"},
           b.normal, positive);
    k.take({"mesh_stiffness", "N/m",
            "of the teeth along the line of action, for penalty contacts (ISO 6336-1: about 2e10 N/m² times "
            "the face width); if absent: Hertz's point contact of the flanks' curvature at the pitch point"},
           b.stiffness, positive);
    const auto* s = k.surface({"surface", "", "the surface of its contacts"}, b.surface);
    k.check(!s || !s->friction, "surface", "must be without friction: sliding of teeth is not modelled");
  }
};

/// rad, the usual pressure angle of 20°
inline constexpr double pressure_angle_20 = 20 * std::numbers::pi / 180;
/// Range of a pressure angle.
inline constexpr Range acute{[](double x) { return x > 0 && x < std::numbers::pi / 2; },
                             "between 0 and 1.5708 rad, both left out (20 degrees are 0.34907)"};
/// Whether a number of teeth is a whole number from 1 to a million.
inline bool whole_teeth(double z) { return z >= 1 && z <= 1e6 && z == std::round(z); }

/// A pair of gears, ideal or with backlash.
struct GearJoint {
  static constexpr std::string_view type = "gear";
  std::string name;                                ///< of the element in the scene
  std::array<int, 2> between{ground, ground};      ///< first and second body: indices, or ground
  std::array<Vec2, 2> at{Vec2{0, 0}, Vec2{0, 0}};  ///< centres
  std::optional<Vec2> teeth = {};                  ///< numbers of teeth; requires tooth_module
  std::optional<double> tooth_module = {};         ///< m
  std::optional<Vec2> pitch_radii = {};            ///< m, replaces teeth and tooth_module
  double pressure_angle = pressure_angle_20;       ///< rad, at the standard distance
  bool internal = false;                           ///< the first gear is a ring with internal teeth
  Flank flank = Flank::forward;                    ///< of an ideal pair
  /// rad, angle of the second body at which its teeth are centred in the gaps, if the first body is
  /// at angle 0 and the line of centres is along x. Empty: not in mesh, so that no tooth acts; the
  /// reader of scenes sets it (dynamics/assembly/meshing.hpp).
  std::optional<double> phase = 0;
  std::optional<Backlash> clearance = {};  ///< empty: an ideal joint
  MeshLoss loss = {};                      ///< of an ideal joint

  std::string_view what() const { return clearance ? "a gear pair" : "a gear pair without backlash"; }

  static void keys(auto& k, auto& j) {
    k.between("two bodies, or \"ground\" and a body", j.between);
    k.ends("the centres of the gears", j.at);
    k.take({"teeth", "", "both numbers of teeth; or pitch_radii"}, j.teeth);
    k.check(!j.teeth || (whole_teeth(j.teeth->x()) && whole_teeth(j.teeth->y())), "teeth",
            "must be two whole numbers from 1");
    k.take({"module", "m", "pitch diameter per tooth; required with teeth"}, j.tooth_module, positive);
    k.take({"pitch_radii", "m", "both pitch radii, in place of the numbers of teeth"}, j.pitch_radii);
    k.check(!j.pitch_radii || (j.pitch_radii->x() > 0 && j.pitch_radii->y() > 0), "pitch_radii",
            "must be two positive lengths");
    k.check(j.teeth.has_value() != j.pitch_radii.has_value(), "",
            "needs exactly one of teeth (with module) and pitch_radii");
    k.check(j.teeth.has_value() == j.tooth_module.has_value(), j.teeth ? "teeth" : "module",
            "teeth and module go together; one of them is missing");
    k.take({"pressure_angle", "rad", "of the teeth at the standard distance; if absent: 20 degrees"},
           j.pressure_angle, acute);
    k.take({"internal", "", "the first gear is a ring with its teeth inside"}, j.internal);
    k.check(!j.internal || j.pitch(0) > j.pitch(1), "internal",
            "makes the first gear the ring, which must be larger");
    k.choose({"flank", "", "loaded flank of a pair without backlash: "}, j.flank);
    MeshLoss::keys(k, j.loss);
    k.from_bodies(
        {"phase", "rad",
         "angle of the second body at which its teeth are centred in the gaps, with the first at angle 0 "
         "and the second centre in the x direction from the first; if absent: the teeth are centred at the "
         "bodies' positions or, if those are absent or out of mesh, where the other joints place the bodies",
         "from the bodies"},
        j.phase);
    if (auto* c = k.group("backlash", j.clearance)) {
      Backlash::keys(k, *c);
      k.check(j.flank == Flank::forward, "flank",
              "applies to pairs without backlash; with backlash either flank is loaded");
    }
    MeshLoss::check(k, j);
  }

  /// Pitch radius (m).
  double pitch(int which) const {
    if (pitch_radii) return which == 0 ? pitch_radii->x() : pitch_radii->y();
    return teeth && tooth_module ? 0.5 * *tooth_module * (which == 0 ? teeth->x() : teeth->y()) : 0;
  }
  /// The flank on one side, with this clearance (m).
  InvoluteFlank mesh(double side, double play) const {
    const double c = std::cos(pressure_angle), kind = internal ? -1 : 1;
    InvoluteFlank m{side, kind, c * pitch(0), kind * c * pitch(1)};
    m.rest = 0.5 * play - kind * m.involute(m.sum() / c);
    m.phase = -m.Rj * phase.value_or(0);
    m.period = 2 * std::numbers::pi * (teeth ? m.Ri / teeth->x() : m.sum());
    return m;
  }
  /// The phase with which the teeth of these bodies are centred in the gaps, or with which an ideal
  /// pair is closed; empty if they cannot mesh.
  std::optional<double> phase_of(const Body& one, const Body& two, bool ideal) const {
    const auto m = mesh(side_of(flank), 0);
    const Vec2 d = placed(two, at[1]) - placed(one, at[0]);
    // The height of teeth beyond their pitch circles is one module.
    const double far = std::abs(d.norm() - m.sum() / std::cos(pressure_angle));
    if (!(d.norm() > m.sum()) || (tooth_module && far > 2 * *tooth_module)) return {};
    double middle =
        m.sum() * std::atan2(d.y(), d.x()) - m.Ri * one.angle.value_or(0) - m.Rj * two.angle.value_or(0);
    if (ideal) middle += m.side * m.kind * (m.involute(d.norm()) + m.kind * m.rest);
    return -middle / m.Rj;
  }
  /// A point s of a body (m, its frame), in the world, at the body's initial position and angle.
  static Vec2 placed(const Body& b, const Vec2& s) {
    const double angle = b.angle.value_or(0), c = std::cos(angle), n = std::sin(angle);
    return b.position.value_or(Vec2{}) + Vec2{c * s.x() - n * s.y(), n * s.x() + c * s.y()};
  }
};

}  // namespace freeplay
