// The observed results of a run and of the runs that it is compared with.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "mechanism/scene.hpp"
#include "simulation/trajectory.hpp"
#include "values/result.hpp"
#include "verification/random_scenes/scene.hpp"

namespace freeplay::verification::random_scenes {

struct Touch {
  std::string contact;
  double t = 0, speed = 0;  ///< s; m/s, of approach, NaN where the contact had not ended with the run
  double duration = 0;      ///< s
  bool impact = true;       ///< else the beginning of a lasting contact
  double slid = 0;          ///< m, at its first sliding rate through its duration
};

struct Sight {
  Result result;
  std::vector<Touch> touches;
  State start;
  State at;  ///< at the instant that was asked for; empty when the run did not come to it
  std::vector<double> start_gap;  ///< m
  /// m, greatest depth within the steps, from the dense output; of time stepping at their ends.
  std::vector<double> depth;
  std::vector<double> measure;  ///< m, what the program measures depth by
  std::vector<std::string> contacts;
  /// Residuals of Newton's and Euler's equations, where forces were watched.
  std::optional<double> newton, momentum;
  Trajectory rows;        ///< where they were asked for
  bool overtime = false;  ///< stopped after the limit
  double went_on = 0;     ///< s, by how much in the second half of it
};

/// s of CPU that one run may take before it counts as hung: ten times what a scene is drawn for.
constexpr double run_limit(Suite suite) {
  if (suite == Suite::rows) return 5;
#if defined(__SANITIZE_ADDRESS__)
  return 100;
#else
  return 10;
#endif
}

struct LookRequest {
  std::optional<double> until = {}, at = {};  ///< s
  std::optional<State> start = {};
  std::size_t most_touches = 1000000;  ///< the run ends soon after as many
  bool forces = false;
  bool rows = false;  ///< of the scene's output steps; nothing within the steps is looked at
  double limit = run_limit(Suite::agreement);  ///< s of CPU
};

/// Runs a scene by a way and looks at it. Throws SceneError where it cannot begin.
Sight look(Scene scene, const Way& way, const LookRequest& request = {});

/// How well single touches are known: a run at the tightest tolerance, and twins of it whose facts differ by `nudge` of
/// themselves. What they change, over nudge and `worst` times, is the scene's own sensitivity; a touch that they lose ends what can be
/// asked.
struct Reference {
  static constexpr double nudge = 1e-6, tolerance = 1e-11;
  static constexpr double worst =
      3;  ///< two twins are nudged at random: the worst way is some three times as bad
  static constexpr int most = 3;                         ///< touches
  const Way* way = nullptr;                              ///< that made it; null: it could not be made
  std::vector<Touch> touches;                            ///< those that can be asked for
  bool all = false;                                      ///< they are all of the run's
  std::vector<double> sensitivity_t, sensitivity_speed;  ///< s and m/s, of each touch, over the nudge
  double greatest_speed = 0;                             ///< m/s, of them
  /// A state before the first touch, and what it is sensitive by.
  State at;
  std::vector<double> sensitivity_q;
  double length = 0, angle = 0;  ///< m, rad: how far bodies came by then
  double position = 0;           ///< m, greatest coordinate: what rounding is measured by
  double duration = 0;           ///< s

  /// s since the touch before.
  double interval(std::size_t k) const { return touches[k].t - (k ? touches[k - 1].t : 0); }
  double shortest_interval(std::size_t k) const;
};
Reference make_reference(const Scene& scene, const Way& way);

}  // namespace freeplay::verification::random_scenes
