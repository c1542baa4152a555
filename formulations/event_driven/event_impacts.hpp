// EventImpacts: impacts of the event-driven scheme, and the end of an accumulation of impacts.
//
// A contact that chatters needs infinitely many impacts to come to rest. With the rate u⁺ after an
// impact, e = u⁺/|u⁻|, and the acceleration g̈ < 0 that closes the contact, the remaining sequence
// lasts
//
//     τ = 2u⁺/(|g̈| (1 − e)).
//
// If the bounces are lower than 1e-9 of the clearance (or a thousand times the rounding error of
// the gap), the contact is closed: the error of its impulses over τ is of order τ². The contact
// onset is recorded at the end of the sequence, with τ as its uncertainty.
#pragma once

#include <string>
#include <vector>

#include "formulations/event_driven/event_dynamics.hpp"
#include "formulations/event_driven/event_findings.hpp"
#include "formulations/event_driven/event_search.hpp"

namespace freeplay {

class EventImpacts {
 public:
  using Vector = std::vector<double>;
  /// `position_error`: error accepted in a step (m); contacts whose gaps close within it of each
  /// other have simultaneous impacts.
  EventImpacts(int contacts, double position_error);
  double position_error() const { return position_error_; }

  /// Called at the beginning of a change of mode: returns the closed contacts and computes their
  /// rates.
  std::vector<int> touching(EventDynamics& d, const Vector& x, double t, const ModeEvent& event);
  /// Solves the impact of the contacts `touching` if one of them approaches; afterwards `touching`
  /// has those that stay closed. Returns an empty text, or the reason of a failure.
  std::string solve(EventDynamics& d, Vector& x, double t, const ModeEvent& event, std::vector<int>& touching,
                    EventPace& pace, EventFindings& findings, WatchedForces& forces);

  /// @name Rates before the present change of mode (m/s)
  ///@{
  double rate(int k) const { return rate_[static_cast<std::size_t>(k)]; }
  double sliding(int k) const { return sliding_[static_cast<std::size_t>(k)]; }
  ///@}
  /// s, τ of a contact that is closed now because its impacts accumulate, else 0.
  double ending(int k) const { return ending_[static_cast<std::size_t>(k)]; }

  /// Contacts of the impact in the present change of mode; empty if there was none.
  const std::vector<int>& in_impact() const { return in_impact_; }
  /// Those of them whose accumulation of bounces ended.
  const std::vector<int>& ended() const { return ended_; }

  template <class M>
  void serialize(M& m) {
    m(crowd_, last_);
  }

 private:
  std::string stay(EventDynamics& d, const Vector& x, double t, const ModeEvent& event,
                   std::vector<int>& touching) const;
  std::string end_bounces(EventDynamics& d, const Vector& x, double t, const std::vector<int>& in_impact,
                          const std::vector<int>& staying, std::vector<int>& over);
  EventFindings::Unloaded unloaded(const EventDynamics& d, double t, const ModeEvent& event,
                                   const std::vector<int>& in_impact) const;

  double position_error_;
  std::vector<double> rate_, sliding_, ending_;
  // contacts with a small separation rate because of impacts elsewhere, less than a bounce
  std::vector<int> thrown_;
  // contacts for which the mode is determined, to find the closing accelerations
  std::vector<int> decided_;
  std::vector<int> in_impact_, ended_;
  int crowd_ = 0;            // number of impacts at one instant
  double last_ = -INFINITY;  // s
};

}  // namespace freeplay
