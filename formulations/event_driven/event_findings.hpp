// EventFindings: diagnostics of an event-driven run's contacts for the reader of the results,
// counted during the run and turned into notes by add_notes().
#pragma once

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "dynamics/system.hpp"

namespace freeplay {

/// EventPace: checks whether events occur too fast for event-driven integration. Three kinds of
/// sequences may never end, and each has its own count: events in a very short time, changes of mode
/// in a very short time, and impacts between several contacts whose intervals shrink. Times are relative to
/// the time scale of the scene.
class EventPace {
 public:
  /// `time_scale`: characteristic time of the scene (s).
  explicit EventPace(double time_scale) : time_scale_(time_scale), span_(0.1 * time_scale) {}

  double time_scale() const { return time_scale_; }
  /// s; an impact within it counts as simultaneous with the one before.
  double instant() const { return 1e-6 * span_; }
  /// Lowers the time scale to `time_scale` (s), if it is shorter.
  void quicken(double time_scale);

  /// @name Counts one more at time t (s); returns the reason if there are too many, or an empty
  /// text
  ///@{
  std::string event(double t);
  std::string mode_change(double t);
  /// `approaching`: the contacts that approached.
  std::string impact(double t, const std::vector<int>& approaching);
  ///@}
  /// Whether the last count was too many.
  bool exceeded() const { return exceeded_; }
  /// Events since restart().
  long events() const { return events_; }
  void restart();

  template <class M>
  void serialize(M& m) {
    m(time_scale_, span_, events_, thousand_since_, window_since_, slow_windows_, changes_, changes_since_,
      impacts_, impacts_since_, half_since_, first_, several_);
  }

 private:
  std::string too_many(std::string what);

  double time_scale_, span_;
  long events_ = 0;
  double thousand_since_ = -INFINITY, window_since_ = -INFINITY;  // s
  int slow_windows_ = 0;  // number of consecutive windows of events in a very short time
  int changes_ = 0;       // of mode since the last impact, in a very short time
  double changes_since_ = -INFINITY;
  int impacts_ = 0;                                            // in the present span
  double impacts_since_ = -INFINITY, half_since_ = -INFINITY;  // s; the latter of their second half
  int first_ = -1;                                             // contact in impact in the present span
  bool several_ = false;                                       // more than one contact was
  bool exceeded_ = false;
};

struct EventFindings {
  /// Impacts decided by a rule other than the impact law.
  struct Exceptions {
    long count = 0;
    double energy = 0;  ///< J: the greatest energy lost in one
    void take(double lost) {
      ++count;
      energy = std::max(energy, lost);
    }
    template <class M>
    void serialize(M& m) {
      m(count, energy);
    }
  };
  /// Contacts closed to rounding, without load and without approach, that took part in an impact;
  /// only the first impact with such contacts.
  struct Unloaded {
    int count = 0, contact = -1;  ///< contact: one of them
    double t = 0, gap = 0;        ///< s, m: the greatest of their gaps
    template <class M>
    void serialize(M& m) {
      m(count, contact, t, gap);
    }
  };

  Exceptions lockups;    ///< friction admitted no finite force on a sliding contact (Painlevé)
  Exceptions unsolved;   ///< no solver found forces that friction admits
  Exceptions inelastic;  ///< no impulses with the restitution of several contacts were found
  Unloaded unloaded;
  /// m, the greatest gap of a contact that took part in an impact of another
  double merged = 0;
  double most_kinetic = 0;  ///< J, the greatest kinetic energy before an impact

  /// `rounding`: accuracy of the gaps (m).
  void add_notes(const System& system, double rounding, std::vector<std::string>& notes) const;

  template <class M>
  void serialize(M& m) {
    m(lockups, unsolved, inelastic, unloaded, merged, most_kinetic);
  }
};

}  // namespace freeplay
