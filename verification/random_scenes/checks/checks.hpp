// A run under assessment, and the checks applied to it.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "verification/random_scenes/checks/sight.hpp"

namespace freeplay::verification::random_scenes {

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

}  // namespace freeplay::verification::random_scenes
