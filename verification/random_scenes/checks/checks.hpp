// A run under assessment, and the checks applied to it.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "verification/random_scenes/checks/sight.hpp"

namespace freeplay::verification::random_scenes {

struct Subject {
  const RandomScene& drawn;
  Scene scene;  ///< as the way runs it
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
  /// No friction, restitution 1, nothing that takes or gives energy.
  bool conservative() const;
  /// Nothing acts from outside: no ground, no gravity, no loads or drives.
  bool alone() const;
  /// Contacts touch at the start.
  bool touching() const;
};

/// A choice among `of` that the stranger and the way alone decide.
int chosen(const Subject& subject, int of);

/// Where `found` departs from the reference: touch by touch, in time and speed, and before the first in position.
///
///     |Δt_k| ≤ share (C_k + t_k) + rounding + late,      |Δv_k| ≤ share (C′_k + v),
///
/// C what the facts do to the touch (Reference), `share` the part of themselves by which the facts may as well have
/// been others.
struct Allowed {
  double share = 0;
  double late = 0;  ///< s
  double since =
      0;  ///< s, the last time before Reference::at at which what acts changed: places are off by what is off since
  double own = 0;  ///< of places and of 1 rad, what a tolerance lets pass however short the way
  bool speeds = true;
  std::vector<double> halved =
      {};  ///< by how much places differ from those of steps half as long, if looked at
};
std::optional<std::string> off_reference(const Sight& found, const Reference& reference,
                                         const Allowed& allowed, double until);

/// A check: nothing where it does not apply or is met, else what is off. With what stands of it in docs/strangers.md.
struct Check {
  const char* name;
  const char* asks;   ///< what is compared with what
  const char* bound;  ///< how far off is right
  const char* why;
  std::optional<std::string> (*judge)(Subject&);
  /// Notes that hold this speak of what is off, besides DOUBTFUL; empty: none do.
  std::string_view noted_by = {};
};
std::span<const Check> conservation_checks();
std::span<const Check> agreement_checks();

/// What a coordinate is at every row.
struct ExpectedRows {
  std::size_t coordinate = 0;
  std::vector<double> x = {}, v = {};
  std::vector<double> sensitivity = {};  ///< of x by shares of the start's size: |Δx| ≤ share · sensitivity
  std::vector<double> error = {};        ///< of the reference itself
  double floor = 0;                      ///< a size that the motion has at least
  double X = 0, V = 0;                   ///< greatest departure from the start and greatest rate
};

/// Every row of a scene's trajectory by one way after another, compared with what is known of it.
class KnownRows {
 public:
  explicit KnownRows(const RandomScene& scene) : scene_(scene) {}
  /// `falsify` changes what was seen of the run before it is judged (for tests of the judge).
  Verdict judge(const Way& way, const std::function<void(Sight&)>& falsify = {});

 private:
  const RandomScene& scene_;
  std::optional<Family> family_;  ///< of which rows are known
  std::vector<ExpectedRows> known_;
};

}  // namespace freeplay::verification::random_scenes
