// Difference between the contact onsets of two runs. This is the common measure of `advice`, of the
// trade-off study and of a run's companion at a shorter step.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "values/event.hpp"

namespace freeplay {

/// Whether an event is an onset: an impact or the beginning of a lasting contact. A contact that is
/// closed at the start is excluded (t within the uncertainty of the first instants), because
/// differences are divided by the time.
inline bool is_onset(const ContactEvent& e) {
  return e.kind != EventKind::separation && e.t > e.t_uncertainty;
}

/// Greatest relative differences over a list of onsets.
struct OnsetDifference {
  double time = 0;     ///< |Δt| over the time since the previous onset of any contact
  double speed = 0;    ///< |Δv|/|v| of approach speeds
  double impulse = 0;  ///< |ΔP|/|P| of normal impulses, if both events are impacts
  long touches = 0;    ///< number compared before the first one without a counterpart
  bool missing = false;
  double greatest() const { return missing ? INFINITY : std::max({time, speed, impulse}); }
};

/// Difference of one onset, `interval` (s) after the previous one: the greatest of the three;
/// infinite if one event is an impact and the other the beginning of a lasting contact.
double event_difference(const ContactEvent& found, const ContactEvent& reference, double interval);

/// Compares the onsets of `found` with those of `reference`, for each contact in their order.
/// Additional onsets of `found` do not count. Simultaneous impacts of two contacts may be in either
/// order: onsets within 1e-6 of their time share the preceding interval.
OnsetDifference onset_difference(const std::vector<ContactEvent>& found,
                                 const std::vector<ContactEvent>& reference);

}  // namespace freeplay
