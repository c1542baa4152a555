// What a study asks of its attractors: the tables [bifurcation] and [basin]. Keys are listed in docs/reference/study.md.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace freeplay {

class Section;
struct Axis;

/// What both have in common: how each run is made, and how attractors are told apart.
struct AttractorPlan {
  std::string formulation = "nonsmooth";
  std::vector<std::string> overrides;  ///< keys of the scene, KEY=VALUE
  std::string section = "every period";
  std::optional<double> period;      ///< s, in place of the drive's
  double discard = 200, keep = 60;   ///< periods
  std::vector<std::string> columns;  ///< by which attractors are told apart; empty: those a section suggests
  double tolerance = 1e-3;
  int most_period = 16;
};

struct BifurcationPlan : AttractorPlan {
  std::size_t axis = 0;         ///< of the study's
  bool up = true, down = true;  ///< each value begins where its neighbour ended
  int starts = 0;               ///< drawn starts of each value, besides
};

struct BasinPlan : AttractorPlan {
  std::size_t x = 0, y = 1;  ///< axes of the study
};

BifurcationPlan read_bifurcation(Section s, const std::vector<Axis>& axes);
BasinPlan read_basin(Section s, const std::vector<Axis>& axes);

}  // namespace freeplay
