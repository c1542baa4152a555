// Revolute joint, ideal or with clearance. The bearing is on the first body, the journal on the
// second.
//
//     ideal            r_j^P − r_i^P = 0:  two rows
//     with clearance   a circle inside a circle: one contact (dynamics/pairs.hpp), with a film if it
//                      names a lubricant
//     with profiles    surfaces that are not round: a contact for each arc where they can touch
//                      (mechanism/profile.hpp, dynamics/profile_pair.hpp)
#pragma once

#include <array>
#include <optional>
#include <string>

#include "mechanism/body.hpp"

namespace freeplay {

/// Clearance of a revolute joint.
struct Clearance {
  double radial = 0;                          ///< m, > 0: bearing radius minus journal radius
  double bearing_radius = 0;                  ///< m, > radial
  int surface = -1;                           ///< index into Mechanism::surfaces
  std::optional<double> bearing_length = {};  ///< m, > 0, required by line contacts, films and wear
  int lubricant = -1;                         ///< index into Mechanism::lubricants; −1: dry
  /// index into Mechanism::profiles of the deviation of each surface; −1: round
  int bearing_profile = -1, journal_profile = -1;

  /// m²/N, ≥ 0, wear coefficient k of Archard's law of each surface; empty: it does not wear
  std::optional<double> bearing_wear = {}, journal_wear = {};

  /// Whether a surface wears.
  bool wears() const { return bearing_wear || journal_wear; }
  /// Whether a surface is not round.
  bool has_profile() const { return bearing_profile >= 0 || journal_profile >= 0; }
};

/// A point of each body, in the body's frame (ground: world), m from the centre of mass.
struct RevoluteJoint {
  static constexpr std::string_view type = "revolute";
  std::string name;                                ///< of the element in the scene
  std::array<int, 2> between{ground, ground};      ///< first and second body: indices, or ground
  std::array<Vec2, 2> at{Vec2{0, 0}, Vec2{0, 0}};  ///< m, one point of each body, in its frame
  std::optional<Clearance> clearance = {};         ///< empty: an ideal joint

  std::string_view what() const {
    return clearance ? "a revolute joint" : "a revolute joint without clearance";
  }

  static void keys(auto& k, auto& j) {
    k.between("two bodies, or \"ground\" and a body", j.between);
    k.ends("the joint's point in each body's frame, from its centre of mass; ground: world", j.at);
    if (auto* c = k.group("clearance", j.clearance)) {
      k.need({"clearance", "m", "radial clearance, bearing radius less journal radius; if absent: ideal"},
             c->radial, positive);
      k.need(
          {"bearing_radius", "m", "radius of the bearing, on the first body; the journal is on the second"},
          c->bearing_radius, positive);
      k.check(c->bearing_radius > c->radial, "bearing_radius", "must be greater than the clearance ",
              c->radial, ", is ", c->bearing_radius);
      k.take({"bearing_length", "m", "length of the bearing; line-contact laws and wear need it"},
             c->bearing_length, positive);
      k.lubricant({"lubricant", "", "lubricant; if absent: dry"}, c->lubricant, c->radial, c->bearing_length);
      k.profile({"bearing_profile", "",
                 "profile by which the bearing's radius deviates, over the angle of the first body; if "
                 "absent: round"},
                c->bearing_profile);
      k.profile(
          {"journal_profile", "",
           "profile by which the journal's radius deviates, over the angle of the second body; if absent: "
           "round"},
          c->journal_profile);
      k.check(c->lubricant < 0 || !c->has_profile(), "lubricant",
              "cannot be combined with a profile: the films are those of round surfaces");
      k.take({"bearing_wear", "m²/N",
              "wear coefficient k of the bearing in Archard's law, depth rate = k × pressure × sliding "
              "speed, ≥ 0; if absent: no wear"},
             c->bearing_wear, non_negative);
      k.take({"journal_wear", "m²/N", "wear coefficient k of the journal, ≥ 0; if absent: no wear"},
             c->journal_wear, non_negative);
      const char* wearing = c->bearing_wear ? "bearing_wear" : "journal_wear";
      k.check(!c->wears() || c->bearing_length, wearing,
              "needs bearing_length: the pressure follows from the force over it");
      k.check(!c->wears() || c->lubricant < 0, wearing,
              "cannot be combined with a lubricant: wear is that of dry contact");
      k.surface({"surface", "", "the surface of its contacts"}, c->surface);
    }
  }
};

}  // namespace freeplay
