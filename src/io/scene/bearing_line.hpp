// The surfaces of a bearing and a journal of which one or both deviate from a circle, as closed lines in figures.
//
// A point of a surface with the normal n, in the direction φ of its body, and its place on the nominal circle of the
// journal about the centre of its own surface are
//
//     P = s + (R + p) n + p′ t,    Q = s + R_j n,    n = (cos φ, sin φ),  t = perp n
//
// with the centre s, the nominal radius R of the surface, that of the journal R_j and the deviation p
// (mechanism/profile.hpp). Magnified M times, clearance, deviations and the distance d of the centres are drawn M
// times as large about the centre of the bearing:
//
//     Q + M (P − Q) + (M − 1) d,    d from the centre of the bearing to that of the surface
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "values/vec2.hpp"

namespace freeplay {

struct Mechanism;
struct RevoluteJoint;

/// Points P and Q, in the same frame (m); the last point is the first one.
struct SurfaceLine {
  std::vector<Vec2> points;   ///< P
  std::vector<Vec2> nominal;  ///< Q

  /// The points with the magnification M, `factor`; `bearing`: centre of the bearing.
  std::vector<Vec2> magnified(double factor, const Vec2& bearing) const;
};

/// Lines of bearing and journal of a joint, in the frames of their bodies; empty for a joint without profiles.
std::vector<SurfaceLine> surface_lines(const Mechanism& mechanism, const RevoluteJoint& joint);

/// Whether a joint of the mechanism has a profile.
bool has_profiles(const Mechanism& mechanism);

/// Whether a shape of a pose is a surface (io/scene/pose_file.hpp).
inline bool is_surface(std::string_view kind) { return kind == "bearing" || kind == "journal"; }

/// Words for the magnified parts of a picture with beams or surfaces.
std::string magnified_words(double factor, bool beams, bool surfaces);

}  // namespace freeplay
