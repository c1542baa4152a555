// Geometry of a mechanism at one state as a table of shapes. plots/figures/pose.cpp draws it.
//
//     shape,name,x,y,a,b          m
//
//     link      a corner of a body, which is a named point or a point of an element; three or more
//               corners form a closed polygon
//     mass      the body's centre of mass
//     pin       a revolute joint without clearance
//     loose     a revolute joint with clearance, a the bearing's radius, or 0 if its surfaces follow
//     bearing   a point of the surface of a joint with a profile, and its place on the nominal circle
//     journal   of the journal about the centre of the surface (io/scene/bearing_line.hpp)
//     weld      a rigid joint
//     slider    a joint with an axis, (a, b) its unit vector
//     support   a point that the ground holds
//     wall      a straight contact, (a, b) along it
//     disc      a round contact or a gear's pitch circle, a its radius
//     outline   a point of the outline of a cam or of an outline contact
//     line      a rack's pitch line, a follower's face, or from a lever to its block and from a body to its
//               outline or the disc on one, to (a, b)
//     spring    a load between (x, y) and (a, b)
//     beam      a point of a beam's line in the order of its length, (a, b) its place on the unloaded
//               beam between the ends of the line (io/scene/beam_line.hpp)
//     joint     any other kind
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "values/state.hpp"
#include "values/vec2.hpp"

namespace freeplay {

struct Scene;

/// A row of the table, with the bodies it moves with; −1 is the ground.
struct PoseShape {
  std::string_view kind;
  std::string name;
  int body;   ///< body of the point (x, y); for a beam, the first one beside it
  Vec2 at;    ///< m, world frame
  int other;  ///< body of (a, b), if that is a point or a direction
  Vec2 more;
};

/// The shapes of a mechanism whose bodies are at q (x, y in m and θ in rad of each body).
std::vector<PoseShape> pose_shapes(const Scene& scene, const std::vector<double>& q);

/// The table as CSV text with its header.
std::string pose_table(const Scene& scene, const State& state);

/// Writes pose.csv, and pose.json with the provenance and the factor by which the figure magnifies the deflection
/// of beams, and clearance and deviations of joints with profiles.
void write_pose(const Scene& scene, const State& state, const std::filesystem::path& folder,
                double magnify = 1);

}  // namespace freeplay
