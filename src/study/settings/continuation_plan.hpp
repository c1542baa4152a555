// The table [continue] of a study. docs/reference/study.md lists its keys.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "values/branch.hpp"

namespace freeplay {

class Section;

/// A second key, over which bifurcations are followed.
struct SecondKeyPlan {
  std::string key;
  double from = 0, to = 0;             ///< SI
  std::optional<double> step;          ///< SI
  std::vector<BifurcationKind> kinds;  ///< empty: all
  double scale = 1;                    ///< displayed value = value · scale
  std::string unit;                    ///< of the displayed value
};

/// Parameters of a continuation (facade/continuation.hpp).
struct ContinuationPlan {
  std::string key;
  std::string formulation = "nonsmooth";
  double from = 0, to = 0;             ///< SI
  std::optional<double> start, step;   ///< SI
  std::vector<std::string> overrides;  ///< keys of the scene, KEY=VALUE
  int periods = 1;
  double settle = 10;
  std::optional<double> period;  ///< s
  int follow_doubled = 1, most_points = 2000;
  double scale = 1;                 ///< displayed value = value · scale
  std::string unit;                 ///< of the displayed value
  std::vector<std::string> events;  ///< expressions of the columns of branch.csv
  std::optional<SecondKeyPlan> second;
};

/// Throws SceneError.
ContinuationPlan read_continuation(Section s);

}  // namespace freeplay
