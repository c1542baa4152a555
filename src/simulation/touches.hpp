// How far apart two runs' touches are: the one measure that advice, trade-off and a run's own companion judge by.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "values/event.hpp"

namespace freeplay {

/// Whether an event is a touch: an impact, or the beginning of a lasting contact. A contact that rests at the start
/// has touched before: its "touch" within the first instants' uncertainty is none, and nothing is divided by it.
inline bool is_touch(const ContactEvent& e) {
  return e.kind != EventKind::separation && e.t > e.t_uncertainty;
}

/// Greatest relative differences over a list of touches.
struct TouchDifference {
  double time = 0;     ///< |Δt| over the time since the touch before, of any contact
  double speed = 0;    ///< |Δv|/|v| of the approach speed
  double impulse = 0;  ///< |ΔP|/|P| of the normal impulse, where both are impacts
  long touches = 0;    ///< compared before the first that has no partner
  bool missing = false;
  double greatest() const { return missing ? INFINITY : std::max({time, speed, impulse}); }
};

/// One touch against another, `interval` (s) after the touch before: the greatest of the three; infinite where one is
/// an impact and the other the beginning of lasting contact.
double touch_off(const ContactEvent& found, const ContactEvent& reference, double interval);

/// Compares touches one by one, in the order of the reference. Two contacts that strike at once may stand in either
/// order: those within 1e-6 of their time share the interval before them.
class TouchComparison {
 public:
  /// The same contact's touch in both runs.
  void add(const ContactEvent& found, const ContactEvent& reference);
  const TouchDifference& so_far() const { return sum_; }
  /// Of the last touch alone.
  double last() const { return last_; }

 private:
  TouchDifference sum_;
  double before_ = 0, since_ = 0, last_ = 0;
};

/// The touches of `found` against those of `reference`, each contact's in their order; those that `found` has beyond
/// do not count.
TouchDifference touch_difference(const std::vector<ContactEvent>& found,
                                 const std::vector<ContactEvent>& reference);

}  // namespace freeplay
