// Where loose joints have their play, from a trajectory, in units of the clearance c:
//
//     journal     (e_x, e_y)/c, the journal's centre from the bearing's, along the axes of the world;  c = gap + |e|
//     guide       its slider's ends across the walls, place along them:  δ = (g_lower − g_upper)/2,  c = (g_lower + g_upper)/2
//     slot        the pin likewise:  δ = (g_right − g_left)/2
//
// δ = 1 is at the upper (left) wall, −1 at the other.
#pragma once

#include <array>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "plots/drawing/figure.hpp"
#include "plots/tables/run_facts.hpp"

namespace freeplay::plots {

struct LooseJoint {
  enum class Kind { journal, guide, slot };
  Kind kind;
  std::string name;
  int frame = -1;           ///< body that the walls belong to; −1 ground
  std::string frame_name;   ///< its name, "the ground"
  double axis[2] = {0, 0};  ///< along the walls in that body's frame; 0 where it is not known
};

/// The loose joints of a run, in the order of its trajectory.
std::vector<LooseJoint> loose_joints(const std::filesystem::path& run, const Scene* scene);

/// Paths of one joint in one span: of a journal one, of a guide those of its rear and front end.
struct PlayPath {
  std::vector<Block> blocks;
  double clearance = 0;      ///< m, mean
  double low = 0, high = 0;  ///< mm along the walls; of a journal nothing
};
/// [joint][span]
std::vector<std::vector<PlayPath>> play_paths(const std::filesystem::path& run,
                                              const std::vector<LooseJoint>& joints,
                                              const std::vector<Span>& spans);

}  // namespace freeplay::plots
