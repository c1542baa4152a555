// Whether events follow each other no faster than event-driven integration resolves. Three sequences have no end that it
// could reach, and each has its own count: events in next to no time, changes of mode in next to no time, and impacts
// with which several contacts throw each other to and fro. Times are measured by the scene's time scale.
#pragma once

#include <cmath>
#include <string>
#include <vector>

namespace freeplay {

class EventPace {
 public:
  /// `time_scale`: s, in which something happens.
  explicit EventPace(double time_scale) : time_scale_(time_scale), span_(0.1 * time_scale) {}

  double time_scale() const { return time_scale_; }
  /// s; an impact within it follows the one before at once.
  double instant() const { return 1e-6 * span_; }
  /// Something happens within `time_scale` (s) at least.
  void quicken(double time_scale);

  /// @name One more, at time t (s): why there are too many, or an empty text
  ///@{
  std::string event(double t);
  std::string mode_change(double t);
  /// `approaching`: the contacts that approached.
  std::string impact(double t, const std::vector<int>& approaching);
  ///@}
  /// Whether the last answer was that there are too many.
  bool exceeded() const { return exceeded_; }
  /// Events since restart().
  long events() const { return events_; }
  void restart();

  template <class M>
  void remember(M& m) {
    m(time_scale_, span_, events_, thousand_since_, window_since_, slow_windows_, changes_, changes_since_,
      impacts_, impacts_since_, first_, several_);
  }

 private:
  std::string too_many(std::string what);

  double time_scale_, span_;
  long events_ = 0;
  double thousand_since_ = -INFINITY, window_since_ = -INFINITY;  // s
  int slow_windows_ = 0;  // one after the other, of events that took next to no time
  int changes_ = 0;       // of mode since the last impact, in next to no time
  double changes_since_ = -INFINITY;
  int impacts_ = 0;  // in the present span
  double impacts_since_ = -INFINITY;
  int first_ = -1;        // contact in impact in the present span
  bool several_ = false;  // contacts were
  bool exceeded_ = false;
};

}  // namespace freeplay
