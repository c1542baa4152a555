// The kinds of constraint row and contact pair that a System consists of. Each kind is a file of
// rows/, pairs.hpp, cam_pairs.hpp, outline_pair.hpp or profile_pair.hpp and is listed here once. Drives and loads are in
// elements.hpp.
#pragma once

#include <string>
#include <tuple>
#include <utility>
#include <variant>
#include <vector>

#include "dynamics/cam_pairs.hpp"
#include "dynamics/outline_pair.hpp"
#include "dynamics/pairs.hpp"
#include "dynamics/profile_pair.hpp"
#include "dynamics/rows/angle.hpp"
#include "dynamics/rows/distance.hpp"
#include "dynamics/rows/mesh.hpp"
#include "dynamics/rows/motion.hpp"
#include "dynamics/rows/point.hpp"
#include "dynamics/rows/reduced_beam.hpp"
#include "dynamics/rows/slide.hpp"
#include "dynamics/rows/sliding.hpp"
#include "dynamics/rows/spin.hpp"
#include "dynamics/rows/turn.hpp"

namespace freeplay {

using ConstraintRows =
    std::tuple<std::vector<PointRows>, std::vector<SlideRow>, std::vector<AngleRow>, std::vector<SpeedRow>,
               std::vector<MotionRow>, std::vector<RatioRow>, std::vector<MeshRow<InvoluteMesh>>,
               std::vector<MeshRow<RackMesh>>, std::vector<DistanceRow>, std::vector<ReducedBeamRows>>;
using Pair =
    std::variant<RoundPair, LinePair, CamFlatPair, CamRollerPair, OutlinePair, FlankPair<InvoluteMesh>,
                 FlankPair<RackMesh>, AngleStopPair, RatioPair, ProfilePair>;
using FrictionRow = std::variant<SlidingRow, SpinRow, TurnRow>;

/// Numbers of rows, contacts, frictions and states that an element adds to the solver.
struct Carried {
  std::string name;
  std::string_view kind;  ///< its word in a scene
  int rows = 0, contacts = 0, frictions = 0, states = 0;
  bool force = false;  ///< whether it adds to the right-hand side
  int families = 0;    ///< of contacts that are searched during the run
};

}  // namespace freeplay
