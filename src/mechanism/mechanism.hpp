// A planar mechanism as its author states it: bodies, joints, contacts, drives and loads.
//
// All values are facts in SI units. Nothing here depends on how the mechanism is solved. Elements
// refer to each other by index into these lists; the ground has index −1. elements.hpp lists the
// kinds of element. dynamics/system.hpp builds the equations of motion from a Mechanism.
#pragma once

#include <string>
#include <vector>

#include "mechanism/beam.hpp"
#include "mechanism/body.hpp"
#include "mechanism/configuration.hpp"
#include "mechanism/curve.hpp"
#include "mechanism/elements.hpp"
#include "mechanism/group.hpp"
#include "mechanism/profile.hpp"
#include "mechanism/surface.hpp"
#include "values/vec2.hpp"

namespace freeplay {

/// The elements of a mechanism. Elements refer to each other by index.
struct Mechanism {
  /// for figures and reports
  std::string title;
  Vec2 gravity{0, 0};        ///< m/s²
  std::vector<Body> bodies;  ///< those of groups and beams come last
  /// joints
  std::vector<Joint> joints;
  /// contacts outside joints
  std::vector<Contact> contacts;
  /// groups of equal discs
  std::vector<Group> groups;
  /// flexible links
  std::vector<Beam> beams;
  /// materials of the contacts
  std::vector<Surface> surfaces;
  /// lubricants of the joints
  std::vector<Lubricant> lubricants;
  /// deviations of bearings and journals from circles
  std::vector<Profile> profiles;
  /// drives
  std::vector<Drive> drives;
  /// loads
  std::vector<Load> loads;
  /// curves that drives and loads name
  std::vector<Curve> curves;
  Configuration assembly;  ///< the requested pose at the start, if any
};

/// Adds a beam with its bodies and elements.
void add_beam(Mechanism& mechanism, Beam beam);
/// Returns the mechanism with full beams in place of reduced ones. Its bodies are the same.
Mechanism with_full_beams(Mechanism mechanism);

/// Returns the mechanism without clearances and without contacts between bodies.
Mechanism idealised(Mechanism mechanism);

/// The drive of constant speed whose revolutions are counted: the one marked as crank, else the
/// first. Null if there is none or if a prescribed motion is marked as crank.
const SpeedDrive* main_drive(const Mechanism& mechanism);

/// Index of the revolute joint whose angle is reported as the crank angle: that of the main drive,
/// else of the first prescribed motion, else of the first drive; −1 if there is none.
int crank_joint(const Mechanism& mechanism);

}  // namespace freeplay
