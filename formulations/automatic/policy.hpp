// When the automatic scheme hands over, as rules on numbers of the two schemes; it steps nothing itself.
//
// To time stepping, when the event-driven scheme
//   - cannot make its step (its own reason), or
//   - shrinks its steps to nothing: near a singular position, where friction is close to lockup, or where events crowd, a thousand
//     steps pass less than a hundredth of what a thousand passed at best so far (StepShrinkage), or
//   - is on trial and passes less time with the same work than time stepping did (SchemeCosts).
//
// Back to the event-driven scheme, when time stepping
//   - has been calm, without impacts, for a while: a tenth of the scene's time scale, twice as long after each return that did not
//     last (HandoverTimes), or
//   - has become the dearer: a scheme's pace is the time that it passes over its factorisations, counts that do not depend on
//     the machine. Time stepping whose pace over the last N factorisations is below that of the event-driven scheme so far gives
//     way to a trial of N/10. Where the trial pays it goes on and N is halved; else time stepping does, with 2N: trials
//     cost a tenth of the work at most (SchemeCosts).
#pragma once

#include <algorithm>
#include <string>
#include <vector>

namespace freeplay {

/// A scheme's place: time (s) and factorisations so far.
struct SchemeProgress {
  double t = 0;
  long cost = 0;
};

/// How often time stepping took over, for how long, why, and how long it must be calm before it gives back.
class HandoverTimes {
 public:
  /// `time_scale`: s, in which something happens in the scene, as it is known so far.
  explicit HandoverTimes(double time_scale) : wait_(0.1 * time_scale) {}
  void take_over(double t, const std::string& why, double time_scale);
  void give_back(double t);
  /// Nothing was struck since `calm_since` (s).
  bool calm(double t, double calm_since) const { return t - std::max(since_, calm_since) > wait_; }
  double since() const { return since_; }  ///< s, of the last time that time stepping took over
  long count() const { return count_; }
  const std::string& reasons() const { return reasons_; }
  /// s, the longest that time stepping had the state; `open`: how long it has it now.
  double longest(double open = 0) const { return std::max(longest_, open); }

  template <class M>
  void remember(M& m) {
    m(since_, wait_, returned_, count_, longest_, reasons_);
  }

 private:
  double since_ = 0, wait_, returned_ = 0;  // s
  long count_ = 0;
  double longest_ = 0;
  std::string reasons_;
};

/// Whether steps of the event-driven scheme shrink to nothing. Steps that a smooth motion makes short are no reason: time stepping
/// needs them as well.
class StepShrinkage {
 public:
  void begin(double t, long events);
  /// Before each step: whether to ask shrunk(), every thousand steps.
  bool due() { return ++steps_ >= 1000; }
  /// `crowded`: contacts are closed, or the position is singular.
  bool shrunk(double t, long events, bool crowded, double time_scale);

  template <class M>
  void remember(M& m) {
    m(steps_, from_, events_, best_);
  }

 private:
  int steps_ = 0;
  double from_ = 0;  // s
  long events_ = 0;  // until then
  double best_ = 0;  // s, the most that a thousand steps passed
};

/// What the two schemes cost.
class SchemeCosts {
 public:
  static constexpr long first_patience = 50'000,  ///< half a second of a small mechanism
      least_patience = 2'000;
  /// A stretch of either scheme begins.
  void begin(const SchemeProgress& now) { from_ = now; }
  /// The event-driven scheme ends a stretch.
  void end_events(const SchemeProgress& now);
  /// Whether time stepping was slower over its last N factorisations than the event-driven scheme has been.
  bool stepping_costs_more(const SchemeProgress& now);
  void begin_trial();
  /// Whether a trial is over that was slower than time stepping; one that paid ends.
  bool trial_failed(const SchemeProgress& events);
  bool on_trial() const { return trial_; }
  long trials() const { return trials_; }
  long won() const { return won_; }
  long patience() const { return patience_; }

  template <class M>
  void remember(M& m) {
    m(events_time_, events_cost_, from_.t, from_.cost, stepping_pace_, patience_, trials_, won_, trial_);
  }

 private:
  bool pays(const SchemeProgress& events) const;
  void end_trial(const SchemeProgress& events);

  double events_time_ = 0;  // s, that the event-driven scheme passed
  long events_cost_ = 0;
  SchemeProgress from_;
  double stepping_pace_ = 0;  // s a factorisation, before the present trial
  long patience_ = first_patience;
  long trials_ = 0, won_ = 0;
  bool trial_ = false;
};

}  // namespace freeplay
