// A run under judgement, and the checks that it is put to.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "verification/strangers/sight.hpp"

namespace freeplay::verification::strangers {

struct Subject {
  const Stranger& stranger;
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

/// A check: nothing where it does not apply or is met, else what is off.
struct Check : CheckFacts {
  std::optional<std::string> (*judge)(Subject&);
  /// Notes that begin with or hold this tell of what is off, besides DOUBTFUL; empty: none do.
  std::string_view told_by = {};
};
std::span<const Check> conservation_checks();
std::span<const Check> agreement_checks();

}  // namespace freeplay::verification::strangers
