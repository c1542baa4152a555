// Numerical settings: the integration methods and finenesses that `freeplay tradeoff` and `advise` compare,
// and their cost and error on a scene, by single events against a reference run and by statistics over starts
// (docs/verification/tradeoff.md).
#pragma once

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "mechanism/options.hpp"
#include "study/runs/case_run.hpp"
#include "values/family.hpp"

namespace freeplay {

/// One method with its fineness. `fineness` is the value of penalty.tolerance, penalty.step (rk4),
/// nonsmooth.step (Moreau–Jean), nonsmooth.step_tolerance (Moreau–Jean with adaptive steps) or
/// nonsmooth.tolerance (event-driven and automatic).
struct Setting {
  Family family = Family::penalty;
  Integrator integrator = Integrator::adams_bashforth_moulton;
  Scheme scheme = Scheme::moreau_jean;
  double fineness = 0;
  Stabilisation stabilisation = Stabilisation::baumgarte;
  bool chosen_steps = false;  ///< adaptive time stepping (Moreau–Jean)

  std::string method() const;  ///< name, such as "adams_bashforth_moulton" or "moreau-jean"
  std::string label() const;   ///< method and fineness
  /// The keys of this setting, as `--set` takes them.
  std::vector<std::string> keys() const;
  void apply(Scene& scene) const;
  /// Whether the fineness is a tolerance; otherwise it is a step (s).
  bool adaptive() const;
};

/// All methods and finenesses, from coarse to fine for each method. Includes those of
/// setting_for().
std::vector<Setting> all_settings(Family family);

/// Accuracy classes of the option `--accuracy`.
enum class Accuracy { fast, balanced, reference };
/// An accuracy class and its name.
struct AccuracyName {
  Accuracy value;
  const char* text;  ///< value of `--accuracy`
};
inline constexpr std::array accuracies{AccuracyName{Accuracy::fast, "fast"},
                                       AccuracyName{Accuracy::balanced, "balanced"},
                                       AccuracyName{Accuracy::reference, "reference"}};
/// The setting of an accuracy class, one of all_settings(). docs/verification/tradeoff.md states
/// the rule.
Setting setting_for(Family family, Accuracy accuracy);

/// Contact onsets and state of a reference run.
struct Reference {
  std::vector<ContactEvent> touches;  ///< contact onsets up to the horizon
  /// s, time of the last of them; without onsets the scene's duration.
  double horizon = 0;
  /// Relative difference up to there between two methods, or between tolerances 100 times apart.
  double accuracy = 0;
  /// Time of the compared state, s: the middle of the flight before the last compared onset; with
  /// fewer than two onsets, before the first one or at the end.
  double state_time = 0;
  State state;            ///< at state_time
  double dissipated = 0;  ///< J, over the scene's duration
  Ending ending;
};

/// Runs the finest setting and compares it with another. The horizon ends where the two differ by
/// more than 1e-6, or after `most` contact onsets.
Reference make_reference(const Scene& scene, Family family, const Conduct& conduct, std::size_t most = 6);

/// The finest setting of a formulation, and the setting it is compared with: another method, or a
/// tolerance 100 times coarser.
std::pair<Setting, Setting> reference_settings(Family family);
/// The reference setting for statistics.
Setting statistics_setting(Family family);

/// ‖a.v − b.v‖∞/‖b.v‖∞.
double velocity_error(const State& a, const State& b);

/// Errors of a run relative to the reference.
struct Errors {
  /// Over the contact onsets: the greatest of |Δt| over the time since the onset before, |Δv|/|v|
  /// and |ΔP|/P.
  double events = 0;
  double state = 0;       ///< ‖v − v_ref‖∞/‖v_ref‖∞ at Reference::state_time
  double energy = 0;      ///< |closure of the energy balance| over its scale, whole run
  double dissipated = 0;  ///< relative difference, whole run; chaotic, so its spread matters
};

/// Cost and errors of one setting on one scene.
struct Measured {
  Setting setting;
  Ending ending;
  Errors errors;
  Work work;
  /// Deviation of long runs' statistics in standard errors (LongRun); infinite if
  /// one failed.
  double statistics = NAN;
  /// s, time of the last contact onset up to which the error was within the bound of `advise`.
  double kept_to = NAN;
  /// Stopped by `advise`, because it cost more than another setting within the error bound.
  bool dearer = false;
  /// s: median, least and greatest CPU time of the repetitions.
  double cpu = 0, cpu_low = 0, cpu_high = 0;
};

/// Deviation of contact onsets, as Errors::events. The onsets of each contact are compared in their
/// order. Infinite if one is missing.
double onset_error(const std::vector<ContactEvent>& found, const std::vector<ContactEvent>& reference);

/// Runs a scene once with a setting.
Measured measure(const Scene& scene, const Setting& setting, const Reference& reference,
                 const Conduct& conduct);

// Statistics of chaotic motion over runs from perturbed starts, and a test whether two settings
// differ by more than the sampling error (Welch's t statistic). `freeplay tradeoff` and `advise`
// use them.

/// Number and length of the runs. Without a drive of prescribed speed, each run is as long as the
/// scene's.
struct Sampling {
  int starts = 0;  ///< fewer than 2: no statistics
  double revolutions = 1;
  std::uint64_t seed = 1;
  Perturbation how;
};

/// Statistics of one setting, with one value for each start.
struct LongRun {
  std::vector<double> lost;    ///< W, mean power dissipated in contacts
  std::vector<double> flight;  ///< share of the time without contact, mean over contacts
  /// Per revolution (per second without a drive of prescribed speed), mean over contacts.
  std::vector<double> impacts;
  std::string stopped;  ///< reason of the first run that did not finish; else empty
};

/// The scene at `sampling.starts` starts from number `first`. Empty if the starts cannot differ, or
/// if the ideal mechanism has no start.
std::vector<Scene> perturbed_starts(const Scene& scene, const Sampling& sampling, int first,
                                    const Conduct& conduct);

/// Runs all starts with all settings in parallel.
std::vector<LongRun> long_runs(const std::vector<Scene>& starts, const std::vector<Setting>& settings,
                               const Conduct& conduct, const std::function<void(double)>& on_progress);

/// Welch's statistic |difference of the means|/√(s₁²/n₁ + s₂²/n₂), the greater of those of the
/// dissipated power and the flight share (Welch, Biometrika 34 (1947) 28). NaN without samples.
double deviation(const LongRun& a, const LongRun& b);

/// Sample mean and sample variance.
struct Moments {
  double mean = 0, variance = 0;  ///< of the sample
};
/// Mean of n values, and their variance with the divisor n − 1.
Moments moments(const std::vector<double>& x);

/// Sample standard deviation over the mean.
double relative_spread(const std::vector<double>& sample);

// Text of an error in tables.

/// Two significant digits; a dash if x is not finite.
inline std::string shown(double x) { return std::isfinite(x) ? fmt::format("{:.1e}", x) : std::string("-"); }

}  // namespace freeplay
