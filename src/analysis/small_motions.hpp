// Small motions of a scene about its equilibrium or its initial state (dynamics/assembly/modes.hpp), and the
// contents of their result files.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "dynamics/assembly/modes.hpp"
#include "values/family.hpp"
#include "values/stop.hpp"
#include "values/table.hpp"

namespace freeplay {

struct Scene;

struct SmallMotions {
  Family family = Family::nonsmooth;  ///< penalty: compliant contacts; nonsmooth: rigid contacts
  bool about_start = false;           ///< about the initial state; otherwise about an equilibrium
  Equilibrium at;
  Modes modes;
  double left = 0;  ///< N, unbalanced force of the initial state
};

/// Throws ModelError if no equilibrium is found, and Interrupted.
SmallMotions small_motions(const Scene& scene, const System& system, Family family, bool about_start,
                           const StopToken& stop);

/// BODY.x, BODY.y or BODY.theta.
std::string coordinate_name(const Scene& scene, int coordinate);

/// modes.csv, equilibrium.csv (positions of the bodies) and static_forces.csv.
struct SmallMotionTables {
  SmallMotionTables(const Scene& scene, const System& system, const SmallMotions& found);
  Table modes, positions, forces;
};
/// modes.json, without provenance.
nlohmann::json to_json(const SmallMotions& found);

}  // namespace freeplay
