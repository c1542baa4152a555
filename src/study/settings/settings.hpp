// Numerical settings as a user trades them: method and fineness, and what each costs and misses on a scene.
#pragma once

#include <array>
#include <cmath>
#include <utility>

#include "mechanism/options.hpp"
#include "study/runs/case_run.hpp"
#include "values/family.hpp"

namespace freeplay {

/// One way to run a scene. `fineness` is penalty.tolerance, penalty.step (rk4), nonsmooth.step (Moreau–Jean),
/// nonsmooth.step_tolerance (Moreau–Jean with chosen steps) or nonsmooth.tolerance (event-driven, automatic).
struct Setting {
  Family family = Family::penalty;
  Integrator integrator = Integrator::adams_bashforth_moulton;
  Scheme scheme = Scheme::moreau_jean;
  double fineness = 0;
  Stabilisation stabilisation = Stabilisation::baumgarte;
  bool chosen_steps = false;  ///< of Moreau–Jean

  std::string method() const;  ///< "adams_bashforth_moulton", "moreau-jean", …
  std::string label() const;   ///< method and fineness
  /// The keys that ask for it, as --set takes them.
  std::vector<std::string> keys() const;
  void apply(Scene& scene) const;
  /// Whether its fineness is a tolerance; else it is a step (s).
  bool adaptive() const;
};

/// Methods × finenesses, from coarse to fine within each method; those of setting_for are among them.
std::vector<Setting> all_settings(Family family);

enum class Accuracy { fast, balanced, reference };
struct AccuracyName {
  Accuracy value;
  const char* text;  ///< as --accuracy takes it
};
inline constexpr std::array accuracies{AccuracyName{Accuracy::fast, "fast"},
                                       AccuracyName{Accuracy::balanced, "balanced"},
                                       AccuracyName{Accuracy::reference, "reference"}};
/// What --accuracy stands for, each among all_settings; the rule stands in docs/verification/tradeoff.md.
Setting setting_for(Family family, Accuracy accuracy);

/// Touches and state that settings are judged by.
struct Reference {
  std::vector<ContactEvent> touches;  ///< up to the horizon
  double horizon = 0;                 ///< s, of the last of them; without touches the scene's duration
  double accuracy =
      0;  ///< relative difference of two methods, or tolerances a hundredfold apart, up to there
  /// s: midway in the flight before the last judged touch; with fewer than two before the first, or at the
  /// end
  double state_time = 0;
  State state;            ///< there
  double dissipated = 0;  ///< J over the scene's duration
  Ending ending;
};

/// By the finest setting, held against another. The horizon ends where the two part by more than 1e-6, and
/// after `most` touches.
Reference make_reference(const Scene& scene, Family family, const Conduct& conduct, std::size_t most = 6);

/// The finest setting of a formulation and the one that it is held against: another method, or a tolerance a
/// hundredfold coarser.
std::pair<Setting, Setting> reference_settings(Family family);
/// The setting that statistics are held against.
Setting statistics_setting(Family family);

/// ‖a.v − b.v‖∞/‖b.v‖∞.
double velocity_error(const State& a, const State& b);

struct Errors {
  double events = 0;  ///< greatest of |Δt| over the time since the touch before, |Δv|/|v| and |ΔP|/P over the
                      ///< reference's touches
  double state = 0;       ///< ‖v − v_ref‖∞/‖v_ref‖∞ at Reference::state_time
  double energy = 0;      ///< |closure of the balance| over its scale, whole run
  double dissipated = 0;  ///< relative difference to the reference's, whole run: chaotic, judge by its spread
};

struct Measured {
  Setting setting;
  Ending ending;
  Errors errors;
  Work work;
  /// Deviation of long runs' statistics in standard errors (long_run.hpp); infinite where one stopped.
  double statistics = NAN;
  /// s, of the last touch to which advice found all within its bound
  double kept_to = NAN;
  bool dearer = false;  ///< advice stopped it: it had cost more than another that keeps the error
  double cpu = 0, cpu_low = 0, cpu_high = 0;  ///< s: median, least and greatest of the repeats
};

/// Deviation of touches: see Errors::events; each contact's in their order. Infinite when one is missing.
double touch_error(const std::vector<ContactEvent>& found, const std::vector<ContactEvent>& reference);

/// Runs a scene with a setting, once.
Measured measure(const Scene& scene, const Setting& setting, const Reference& reference,
                 const Conduct& conduct);

}  // namespace freeplay
