// Impacts of the event-driven scheme, and the end of those that accumulate.
//
// A contact that bounces ever faster would take infinitely many impacts to come to rest. With u⁺ its rate after an impact,
// e = u⁺/|u⁻| and g̈ < 0 what presses it, the rest of the sequence lasts
//
//     τ = 2u⁺/(|g̈| (1 − e)).
//
// Once its bounces are lower than 1e-9 of the clearance (or a thousand roundings of the gap) the contact is closed: its
// impulses over τ are the same up to τ², and the touch is recorded at the end of the sequence, with τ as its uncertainty.
#pragma once

#include <string>
#include <vector>

#include "formulations/event_driven/event_findings.hpp"
#include "formulations/event_driven/event_pace.hpp"
#include "formulations/event_driven/event_search.hpp"
#include "formulations/event_driven/watched_forces.hpp"

namespace freeplay {

class EventImpacts {
 public:
  using Vector = std::vector<double>;
  /// `position_error`: m, accepted in a step; contacts whose gaps close within it of each other are in impact at once.
  EventImpacts(int contacts, double position_error);

  /// At the beginning of a change of mode: the contacts that touch, with their rates.
  std::vector<int> touching(EventDynamics& d, const Vector& x, double t, const ModeEvent& event);
  /// Solves the impact of the touching contacts if one approaches; leaves in `touching` those that stay. An empty text, or
  /// why it cannot be solved.
  std::string solve(EventDynamics& d, Vector& x, double t, const ModeEvent& event, std::vector<int>& touching,
                    EventPace& pace, EventFindings& findings, WatchedForces& forces);

  /// @name Before the present change of mode (m/s)
  ///@{
  double rate(int k) const { return rate_[static_cast<std::size_t>(k)]; }
  double sliding(int k) const { return sliding_[static_cast<std::size_t>(k)]; }
  ///@}
  /// s, τ of a contact that is closed by accumulation now, else 0.
  double ending(int k) const { return ending_[static_cast<std::size_t>(k)]; }

  template <class M>
  void remember(M& m) {
    m(crowd_, last_);
  }

 private:
  std::string stay(EventDynamics& d, const Vector& x, double t, const ModeEvent& event,
                   std::vector<int>& touching) const;
  std::string end_bounces(EventDynamics& d, const Vector& x, double t, const std::vector<int>& struck,
                          const std::vector<int>& staying, std::vector<int>& over);
  EventFindings::Unloaded unloaded(const EventDynamics& d, double t, const ModeEvent& event,
                                   const std::vector<int>& struck) const;

  double position_error_;
  std::vector<double> rate_, sliding_, ending_;
  std::vector<int> thrown_;   // contacts that an impact elsewhere threw off, by less than a bounce
  std::vector<int> decided_;  // contacts that a mode is chosen of, for what presses
  int crowd_ = 0;             // impacts at one instant
  double last_ = -INFINITY;   // s
};

}  // namespace freeplay
