// Continuation of periodic motions in one key of a scene, with their bifurcations
// (docs/theory/continuation.md).
//
// Usage:
//
//     const auto found = freeplay::continue_orbit(scene, {.key = "curves.shake.amplitude",
//                                                         .from = 1e-3, .to = 5e-3});
//     for (const auto& b : found.bifurcations) use(b.kind, b.at.parameter);
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "values/branch.hpp"
#include "values/stop.hpp"

namespace freeplay {

struct Scene;

/// A second key, over which the bifurcations of the branches are followed.
struct SecondKey {
  std::string key;                          ///< likewise; its value in the scene is within the range
  double from = 0, to = 0;                  ///< SI, range
  std::optional<double> step = {};          ///< greatest step, SI; default: a fiftieth of the range
  std::vector<BifurcationKind> kinds = {};  ///< that are followed; empty: all but sequence
};

/// A quantity of motions whose zeros are located on the branches.
struct BranchQuantity {
  std::string name;                                 ///< in the branches' list of bifurcations
  std::function<double(const BranchPoint&)> value;  ///< NaN: not defined for this motion
};

/// A branch of an earlier result, which goes on from its last motion.
struct BranchRestart {
  BranchPoint last;    ///< with the state, the period and the number of periods of its orbit
  bool rising = true;  ///< whether the key increases along the branch
  std::string begins;  ///< as BranchEnd::begins
};

/// Which branch is computed.
struct ContinuationRequest {
  std::string formulation = "nonsmooth";  ///< or "penalty"
  std::string key;                        ///< of the scene, as SensitivityRequest::to names it
  double from = 0;                        ///< SI, value at which the branch begins
  double to = 0;                          ///< SI, other end of the range
  /// SI, value within the range at which the branch begins instead; it is then followed to both sides.
  std::optional<double> start = {};
  /// Greatest step of the key, SI; default: a fiftieth of the range.
  std::optional<double> step = {};
  int periods = 1;                          ///< periods of the drive after which the motion repeats
  double settle = 10;                       ///< periods of the drive before the first guess
  std::optional<double> period = {};        ///< s, as OrbitRequest::period
  int follow_doubled = 1;                   ///< number of successive period doublings that are followed
  int most_points = 2000;                   ///< of each branch
  std::optional<SecondKey> second = {};     ///< for curves over two keys
  std::vector<BranchQuantity> events = {};  ///< whose zeros are reported
  /// Branches that go on, in place of a search at `from` or `start`. New ones
  /// have numbers above `branches`.
  std::vector<BranchRestart> restarts = {};
  int branches = 0;  ///< number of the branches that exist already
  /// Stop request; the function then throws Interrupted.
  StopToken stop = {};
};

/// Branches that the caller advances: while (branches.advance()) use(branches.found());
class Continuation {
 public:
  /// Refers to the scene.
  Continuation(const Scene& scene, const ContinuationRequest& request);
  ~Continuation();
  /// Makes one step, which appends motions, bifurcations or a point of a curve to found(), or nothing. False:
  /// the branches and curves are complete. Throws as continue_orbit().
  bool advance();
  /// The results so far. A curve in progress has its points in the order in which they were found.
  const Branches& found() const;

 private:
  class Implementation;
  std::unique_ptr<Implementation> own_;
};

/// Follows the branch from the periodic motion at `from` round folds to one end
/// of the range, and the branches that begin at its bifurcations; or continues
/// those of an earlier result. If there is no first motion, Branches::failure
/// has the reason. Throws ModelError for an unknown key and for a scheme
/// without derivatives.
Branches continue_orbit(const Scene& scene, const ContinuationRequest& request);

}  // namespace freeplay
