// Positions of joints within their clearance c, from a trajectory, in units of c:
//
//     journal   (e_x, e_y)/c: centre of the journal relative to the bearing, world axes
//               c = gap + |e|
//     guide     δ/c of both ends of the slider, across the walls
//               δ = (g_lower − g_upper)/2,  c = (g_lower + g_upper)/2
//     slot      δ/c of the pin, across the walls
//               δ = (g_right − g_left)/2,   c = (g_right + g_left)/2
//
// δ/c = 1 is contact with the upper (left) wall, −1 with the other. Guides and slots also have the
// position along their walls.
#pragma once

#include <array>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "plots/drawing/figure.hpp"
#include "plots/tables/run_facts.hpp"

namespace freeplay::plots {

struct ClearanceJoint {
  enum class Kind { journal, guide, slot };
  Kind kind;
  std::string name;
  int frame = -1;           ///< body with the walls; −1: ground
  std::string frame_name;   ///< its name, "the ground"
  double axis[2] = {0, 0};  ///< direction of the walls in the frame of that body; 0 if unknown
};

/// The joints with clearance of a run, in the order of its trajectory.
std::vector<ClearanceJoint> clearance_joints(const std::filesystem::path& run, const Scene* scene);

/// Path of one joint in one time span: one block for a journal or slot, two for the rear and front
/// end of a guide.
struct PlayPath {
  std::vector<Block> blocks;
  /// per block: whether it stays within 1e-3 c of its first point, and is drawn as a point
  std::vector<bool> fixed = {};
  std::vector<std::array<double, 2>> first = {};  ///< per block: that point, in clearances
  double clearance = 0;                           ///< m, mean value
  double low = 0, high = 0;                       ///< mm, range along the walls; unused for a journal
};
/// Reads all paths: [joint][span].
std::vector<std::vector<PlayPath>> play_paths(const std::filesystem::path& run,
                                              const std::vector<ClearanceJoint>& joints,
                                              const std::vector<Span>& spans);

}  // namespace freeplay::plots
