// A cam on the first body and a follower on the second: one contact, which may separate.
//
//     flat      the face touches an outline with the support function base_radius + lift(ψ) in the
//               direction ψ (dynamics/cam_pairs.hpp)
//     roller    the roller's centre is on the pitch curve of polar radius base_radius +
//               roller_radius + lift(φ) (dynamics/cam_pairs.hpp)
//
// Either follower, guided radially, therefore moves by the lift. Angles are measured on the cam
// from its body's x axis, counterclockwise. The stiffness of penalty contacts is that of the place
// with the greatest curvature, for all angles.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>

#include "mechanism/body.hpp"
#include "mechanism/cam_profile.hpp"
#include "mechanism/elements/spring_law.hpp"

namespace freeplay {

/// A cam on the first body and a follower on the second.
struct CamContact {
  /// Face of the follower.
  enum class Follower { flat, roller };
  static constexpr std::string_view type = "cam";
  std::string name;                            ///< of the element in the scene
  std::array<int, 2> between{ground, ground};  ///< first and second body: indices, or ground
  /// The cam's point; a point of the face, or the roller's centre.
  std::array<Vec2, 2> at{Vec2{0, 0}, Vec2{0, 0}};
  /// face of the follower
  Follower follower = Follower::flat;
  /// Unit vector along the face, in the second body's frame; the cam is on its left.
  Vec2 axis{1, 0};
  double roller_radius = 0;  ///< m, > 0 for a roller
  double base_radius = 0;    ///< m, > 0
  /// law of the rise and return, without a table
  CamLaw law = CamLaw::cycloidal;
  double lift = 0;                                  ///< m, ≥ 0
  double start = 0, rise = 0, dwell = 0, fall = 0;  ///< rad
  SpringTable table = {};                           ///< (angle, lift); empty: use `law`
  int surface = -1;                                 ///< index into Mechanism::surfaces

  std::string_view what() const {
    return follower == Follower::flat ? "a cam with a flat follower" : "a cam with a roller";
  }

  /// The lift of this cam.
  CamProfile profile() const {
    return table.empty() ? CamProfile::standard(law, lift, start, rise, dwell, fall)
                         : CamProfile::through(table);
  }
  /// Least radii of curvature of the curve that the follower's point follows, and their place. The
  /// curve is the outline under a flat face, with radius H + H'', or the pitch curve of a roller.
  /// `hollow` is the least radius of concave places.
  struct Curvature {
    /// m and rad: least radius of convex places, of concave ones, and their angle
    double round = std::numeric_limits<double>::infinity(), hollow = round, at = 0;
    /// m, least lift over the turn
    double least_lift = 0;
  };
  /// The least radii of curvature for a lift.
  Curvature curvature(const CamProfile& profile) const {
    Curvature c;
    profile.each([&](double phi, const CamProfile::Value& y) {
      c.least_lift = std::min(c.least_lift, y.h);
      double rho = base_radius + y.h + y.d2;
      if (follower == Follower::roller) {
        const double r = base_radius + roller_radius + y.h, square = r * r + y.d1 * y.d1;
        rho = square * std::sqrt(square) / (r * r + 2 * y.d1 * y.d1 - r * y.d2);
        if (rho < 0) c.hollow = std::min(c.hollow, -rho);
        if (!(rho > 0)) return;
      }
      if (rho < c.round) c.round = rho, c.at = phi;
    });
    return c;
  }

  static void keys(auto& k, auto& c) {
    k.between("two bodies, or \"ground\" and a body; a plane or a cam is on the first", c.between);
    k.ends("the cam's point, from which angles and radii count; a point of the face, or the roller's centre",
           c.at);
    k.choose({"follower", "", "the second body's part: "}, c.follower);
    if (k.when(c.follower == Follower::flat, {"axis"}, "is of a flat follower"))
      k.axis("direction of the face in the second body's frame; the cam lies on its left", c.axis);
    if (k.when(c.follower == Follower::roller, {"roller_radius"}, "is of a roller"))
      k.need({"roller_radius", "m", "radius of the roller"}, c.roller_radius, positive);
    k.need({"base_radius", "m", "base radius of the cam"}, c.base_radius, positive);
    k.pairs({"lift_table", "rad, m",
             "[[angle on the cam, lift], ...], increasing within a turn: joined by a periodic cubic spline; "
             "in place of law, lift, rise, dwell, return"},
            c.table);
    if (k.when(c.table.empty(), {"law", "lift", "start", "rise", "dwell", "return"},
               "cannot be combined with lift_table")) {
      k.choose({"law", "", "of rise and return: "}, c.law);
      k.need({"lift", "m", "greatest lift"}, c.lift, non_negative);
      k.take({"start", "rad", "cam angle at the beginning of the rise"}, c.start);
      k.need({"rise", "rad", "angle of the rise"}, c.rise, positive);
      k.take({"dwell", "rad", "angle of the dwell at the greatest lift"}, c.dwell, non_negative);
      k.need({"return", "rad", "angle of the return; no lift over the rest of the turn"}, c.fall, positive);
      k.check(c.rise + c.dwell + c.fall <= CamProfile::turn * (1 + 1e-9), "rise",
              "rise, dwell and return must fit into a turn, 2π, are ", c.rise + c.dwell + c.fall);
    } else {
      k.check(c.table.size() >= 3, "lift_table", "must have three points or more, has ",
              static_cast<double>(c.table.size()));
      k.check(c.table.back().first < c.table.front().first + CamProfile::turn * (1 - 1e-9), "lift_table",
              "must stay within one turn, without the first point again at its end; spans ",
              c.table.back().first - c.table.front().first);
    }
    k.surface({"surface", "", "the surface of the contact"}, c.surface);
    c.check_outline(k);
  }
  /// Refuses an impossible outline.
  void check_outline(auto& k) const {
    if (table.empty() && !(rise > 0)) return;  // keys() is called to list the keys
    const auto c = curvature(profile());
    const char* key = table.empty() ? "lift" : "lift_table";
    k.check(c.least_lift > -base_radius, key, "reaches below the cam's point: least lift ", c.least_lift);
    if (follower == Follower::flat)
      k.check(c.round > 0, "base_radius", "is too small for this lift: base_radius + lift + lift'' is ",
              c.round, " m at ", c.at,
              " rad, the outline would have a hollow or a cusp that a flat face cannot follow");
    else
      k.check(c.round > roller_radius, "roller_radius",
              "is too great for this lift: the pitch curve has a radius of ", c.round, " m at ", c.at,
              " rad, the roller would undercut the cam");
  }
};

inline constexpr auto follower_names =
    complete<CamContact::Follower>({{CamContact::Follower::flat, "flat", "a straight face"},
                                    {CamContact::Follower::roller, "roller", "a disc"}});
constexpr std::span<const Choice<CamContact::Follower>> choices(CamContact::Follower) {
  return follower_names;
}

}  // namespace freeplay
