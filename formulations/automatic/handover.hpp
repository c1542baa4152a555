// Handover between the nonsmooth schemes: the data that one passes to another in the middle of a run, and the
// rules of when.
#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "values/ledger.hpp"
#include "values/state.hpp"

namespace freeplay {

struct Handover {
  struct Contact {
    bool closed = false;  // closed in the last mode or step
    bool logged = false;  // the log has its onset, but not its separation
    // s, N s: onset and impulses that the log has so far
    double t_onset = 0, impulse_n = 0, impulse_t = 0;
  };
  State state;
  std::vector<Contact> contacts;
  EnergyLedger integrals;
  Extremes extremes;
  Work work;
};

// Rules of the automatic scheme: when one scheme hands over to the other. They use numbers only and
// step nothing.
//
// Time stepping takes over if the event-driven scheme
//   - cannot make its step (its own reason), or
//   - has steps that shrink towards zero: near a singular position, where friction is close to
//     lockup, or where events accumulate, a thousand steps cover less than a hundredth of the
//     greatest time that a thousand steps have covered so far (StepShrinkage), or
//   - is on trial and covers less time with the same work than time stepping did (SchemeCosts).
//
// The event-driven scheme takes over again if time stepping
//   - has been calm, without impacts, for a while: a tenth of the scene's time scale, and twice as
//     long after each return that did not last (HandoverTimes), or
//   - has become the more expensive scheme. The pace of a scheme is the time that it covers per
//     factorisation; such counts do not depend on the machine. If the pace of time stepping over
//     the last N factorisations is below that of the event-driven scheme so far, the event-driven
//     scheme gets a trial of N/10. If the trial succeeds, it continues and N is halved. Otherwise
//     time stepping continues with 2N, so that trials cost a tenth of the work at most
//     (SchemeCosts).

/// Progress of a scheme: time (s) and factorisations so far.
struct SchemeProgress {
  double t = 0;
  long cost = 0;
};

/// Counts and reasons of handovers to time stepping, its longest duration, and the calm time that
/// it needs before it hands back.
class HandoverTimes {
 public:
  /// `time_scale`: characteristic time of the scene (s), as known so far.
  explicit HandoverTimes(double time_scale) : wait_(0.1 * time_scale) {}
  void take_over(double t, const std::string& why, double time_scale);
  void give_back(double t);
  /// Whether the calm time has passed; no impact has occurred since `calm_since` (s).
  bool calm(double t, double calm_since) const { return t - std::max(since_, calm_since) > wait_; }
  double since() const { return since_; }  ///< s, of the last handover to time stepping
  long count() const { return count_; }
  const std::string& reasons() const { return reasons_; }
  /// s, the longest duration of time stepping; `open`: its duration since the last handover.
  double longest(double open = 0) const { return std::max(longest_, open); }

  template <class M>
  void serialize(M& m) {
    m(since_, wait_, returned_, count_, longest_, reasons_);
  }

 private:
  double since_ = 0, wait_, returned_ = 0;  // s
  long count_ = 0;
  double longest_ = 0;
  std::string reasons_;
};

/// Whether steps of the event-driven scheme shrink towards zero. Steps that are short because the
/// smooth motion is fast do not count: time stepping needs them as well.
class StepShrinkage {
 public:
  void begin(double t, long events);
  /// Called before each step: whether to call shrunk(), every thousand steps.
  bool due() { return ++steps_ >= 1000; }
  /// `crowded`: contacts are closed, or the position is singular.
  bool shrunk(double t, long events, bool crowded, double time_scale);

  template <class M>
  void serialize(M& m) {
    m(steps_, from_, events_, best_);
  }

 private:
  int steps_ = 0;
  double from_ = 0;  // s
  long events_ = 0;  // at the beginning of these steps
  double best_ = 0;  // s, the greatest time that a thousand steps have covered
};

/// Costs of the two schemes.
class SchemeCosts {
 public:
  /// First and least N, in factorisations; the first is half a second of CPU time for a small
  /// mechanism.
  static constexpr long first_patience = 50'000, least_patience = 2'000;
  /// Begins a stretch of either scheme.
  void begin(const SchemeProgress& now) { from_ = now; }
  /// Ends a stretch of the event-driven scheme.
  void end_events(const SchemeProgress& now);
  /// Whether time stepping was slower over its last N factorisations than the event-driven scheme
  /// has been so far.
  bool stepping_costs_more(const SchemeProgress& now);
  void begin_trial();
  /// Whether a trial has ended slower than time stepping. A trial that was faster ends as
  /// successful.
  bool trial_failed(const SchemeProgress& events);
  bool on_trial() const { return trial_; }
  long trials() const { return trials_; }
  long won() const { return won_; }
  long patience() const { return patience_; }

  template <class M>
  void serialize(M& m) {
    m(events_time_, events_cost_, from_.t, from_.cost, stepping_pace_, patience_, trials_, won_, trial_);
  }

 private:
  bool pays(const SchemeProgress& events) const;
  void end_trial(const SchemeProgress& events);

  double events_time_ = 0;  // s, covered by the event-driven scheme
  long events_cost_ = 0;
  SchemeProgress from_;
  double stepping_pace_ = 0;  // s per factorisation, before the present trial
  long patience_ = first_patience;
  long trials_ = 0, won_ = 0;
  bool trial_ = false;
};

}  // namespace freeplay
