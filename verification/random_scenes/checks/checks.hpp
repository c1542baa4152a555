// A random scene under assessment in this process: the observed results of its run and of the runs
// that it is compared with, and the checks applied to them.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

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

struct Subject {
  const RandomScene& drawn;
  Scene scene;  ///< as the method runs it
  const Way& way;
  Sight sight;
  Reference reference;

  double tolerance() const {
    if (way.family == Family::penalty) return scene.penalty.tolerance;
    const auto& o = scene.nonsmooth;
    const bool steps = o.scheme_in_force() == Scheme::moreau_jean || sight.result.work.handovers > 0;
    return steps ? o.step_tolerance : o.tolerance;
  }
  bool lubricated() const;
  /// No friction, restitution 1, no element that dissipates or adds energy.
  bool conservative() const;
  /// No external action: no ground, no gravity, no loads or drives.
  bool alone() const;
  /// Some beams are reduced: their pieces are not transformed, and their modes store energy beside the loads.
  bool reduced() const;
  /// Some contacts are closed at the start.
  bool touching() const;
};

/// A choice among `of`, determined by the random scene and the method alone.
int chosen(const Subject& subject, int of);

/// Deviation of `found` from the reference: contact by contact, in time and speed, and before the
/// first contact in position.
///
///     |Δt_k| ≤ share (C_k + t_k) + rounding + late,      |Δv_k| ≤ share (C′_k + v),
///
/// C is the sensitivity of the contact to the parameters (Reference), `share` the relative change
/// of the parameters that is equivalent to the permitted errors.
struct Allowed {
  double share = 0;
  double late = 0;  ///< s
  double since =
      /// s, the last time before Reference::at at which a load changed: positions may deviate by
      /// the error
      0;
  ///< since then
  double own = 0;  ///< of positions and of 1 rad, the error that a tolerance permits however short the motion
  bool speeds = true;
  /// differences of positions from those with half the step, if computed
  std::vector<double> halved = {};
};
std::optional<std::string> off_reference(const Sight& found, const Reference& reference,
                                         const Allowed& allowed, double until);

/// A check: nothing where it does not apply or is met, else a description of the deviation. With
/// its text for docs/verification/random-scenes.md.
struct Check {
  const char* name;
  const char* asks;   ///< the quantities compared
  const char* bound;  ///< the permitted deviation
  const char* why;
  std::optional<std::string> (*assess)(Subject&);
  /// Notes that contain this report the deviation too, besides warnings; empty: none do.
  std::string_view noted_by = {};
};
std::span<const Check> conservation_checks();
std::span<const Check> agreement_checks();

/// Expected values of a coordinate at every row.
struct ExpectedRows {
  std::size_t coordinate = 0;
  std::vector<double> x = {}, v = {};
  std::vector<double> sensitivity =
      /// of x by relative changes of the start: |Δx| ≤ share · sensitivity
      {};
  std::vector<double> error = {};  ///< of the reference itself
  double floor = 0;                ///< a lower bound of the size of the motion
  double X = 0, V = 0;             ///< greatest departure from the start and greatest rate
};

/// Compares every row of a scene's trajectory with its reference, for one method after another.
class KnownRows {
 public:
  explicit KnownRows(const RandomScene& scene) : scene_(scene) {}
  /// `falsify` changes the observed results of the run before the assessment (for tests of the
  /// checks).
  Verdict assess(const Way& way, const std::function<void(Sight&)>& falsify = {});

 private:
  const RandomScene& scene_;
  std::optional<Family> family_;  ///< of which rows are known
  std::vector<ExpectedRows> known_;
};

/// The checks without a reference, in their order.
std::vector<Check> checks();

/// `falsify` changes the observed results of the run before the assessment (for tests of the
/// checks).
Verdict assess(const RandomScene& scene, const Way& way, const std::function<void(Sight&)>& falsify = {});
/// By several methods, whose references are made once; `seen` after each.
void assess(const RandomScene& scene, std::span<const Way* const> by,
            const std::function<void(const Verdict&)>& seen);

}  // namespace freeplay::verification::random_scenes
