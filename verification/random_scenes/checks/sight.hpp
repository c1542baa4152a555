// The observed results of a run and of the runs that it is compared with.
#pragma once

#include "simulation/trajectory.hpp"
#include "values/result.hpp"
#include "verification/random_scenes/scene.hpp"
#include "verification/support/runs.hpp"

namespace freeplay::verification::random_scenes {

struct ContactOnset {
  std::string contact;
  /// s; m/s, approach speed, NaN if the contact had not ended with the run
  double t = 0, speed = 0;
  double duration = 0;  ///< s
  bool impact = true;   ///< else the beginning of a lasting contact
  double slid = 0;      ///< m, at its first sliding rate through its duration
};

struct Sight {
  Result result;
  std::vector<ContactOnset> touches;
  State start;
  State at;                       ///< at the requested instant; empty if the run did not reach it
  std::vector<double> start_gap;  ///< m
  /// m, greatest depth within the steps, from the dense output; for time stepping at the ends of
  /// steps.
  std::vector<double> depth;
  std::vector<double> measure;  ///< m, the program's reference length of depth
  std::vector<std::string> contacts;
  /// Residuals of Newton's and Euler's equations, if forces were recorded.
  std::optional<double> newton, momentum;
  Trajectory rows;        ///< if requested
  bool overtime = false;  ///< stopped by the time limit
  double went_on = 0;     ///< s, simulated time in the second half of the limit
};

/// s of CPU that one run may take before it counts as hung: ten times the duration that scenes are
/// drawn for.
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
  std::size_t most_touches = 1000000;  ///< the run ends soon after this number of contacts
  bool forces = false;
  bool rows = false;  ///< at the scene's output steps; nothing within the steps is observed
  double limit = run_limit(Suite::agreement);  ///< s of CPU
};

/// Runs a scene by a method and observes it. Throws SceneError if it cannot begin.
Sight look(Scene scene, const Way& way, const LookRequest& request = {});

/// Accuracy of the known contacts: a run at the tightest tolerance, and twins of it whose
/// parameters differ relatively by `nudge`. Their change, over nudge and times `worst`, is the
/// sensitivity of the scene; a contact that they lose ends the comparison.
struct Reference {
  static constexpr double nudge = 1e-6, tolerance = 1e-11;
  static constexpr double worst =
      3;  ///< two twins have random changes: the worst case is about three times as large
  static constexpr int most = 3;      ///< contacts
  const Way* way = nullptr;           ///< that made it; null: no method could
  std::vector<ContactOnset> touches;  ///< those that can be compared
  bool all = false;                   ///< they are all contacts of the run
  /// s and m/s, of each contact, over the nudge
  std::vector<double> sensitivity_t, sensitivity_speed;
  double greatest_speed = 0;  ///< m/s, of them
  /// A state before the first contact, and its sensitivity.
  State at;
  std::vector<double> sensitivity_q;
  double length = 0, angle = 0;  ///< m, rad: the distance that bodies have moved by then
  double position = 0;           ///< m, greatest coordinate: the scale of rounding
  double duration = 0;           ///< s

  /// s since the previous contact.
  double interval(std::size_t k) const { return touches[k].t - (k ? touches[k - 1].t : 0); }
  double shortest_interval(std::size_t k) const;
};
Reference make_reference(const Scene& scene, const Way& way);

}  // namespace freeplay::verification::random_scenes
