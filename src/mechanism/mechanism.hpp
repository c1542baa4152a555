// The mechanism as its author states it: facts only, in SI units, nothing about how it will be solved. The kinds of its
// elements are listed in elements.hpp.
#pragma once

#include <string>
#include <vector>

#include "mechanism/body.hpp"
#include "mechanism/configuration.hpp"
#include "mechanism/curve.hpp"
#include "mechanism/elements.hpp"
#include "mechanism/group.hpp"
#include "mechanism/surface.hpp"
#include "values/vec2.hpp"

namespace freeplay {

struct Mechanism {
  std::string title;
  Vec2 gravity{0, 0};        ///< m/s²
  std::vector<Body> bodies;  ///< those of groups behind the others
  std::vector<Joint> joints;
  std::vector<Contact> contacts;
  std::vector<Group> groups;
  std::vector<Surface> surfaces;
  std::vector<Lubricant> lubricants;
  std::vector<Drive> drives;
  std::vector<Load> loads;
  std::vector<Curve> curves;
  Configuration assembly;  ///< which pose it starts in, where that is asked for
};

/// The same mechanism with every clearance closed, and without contacts between bodies.
Mechanism idealised(Mechanism mechanism);

/// The drive of constant speed whose turns are counted, if there is one: the one that says so, else the first; none where
/// another motion says so.
const SpeedDrive* main_drive(const Mechanism& mechanism);

/// The revolute joint whose angle is reported as the crank angle, −1: none. That of the main drive, else of the first
/// prescribed motion, else of the first drive.
int crank_joint(const Mechanism& mechanism);

}  // namespace freeplay
