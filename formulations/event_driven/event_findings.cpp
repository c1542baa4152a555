#include "formulations/event_driven/event_findings.hpp"

#include <fmt/format.h>

#include "values/diagnostic.hpp"

namespace freeplay {

void EventPace::quicken(double time_scale) {
  time_scale_ = std::min(time_scale_, time_scale);
  span_ = 0.1 * time_scale_;
}

std::string EventPace::too_many(std::string what) {
  exceeded_ = true;
  return what;
}

/// A thousand events in a very short time, or several ten thousand in a small part of the time
/// scale, are more than the scheme can resolve.
std::string EventPace::event(double t) {
  constexpr long window = 10'000, most = 3;
  if (++events_ % 1000 == 0) {
    if (t - thousand_since_ < 1e-3 * time_scale_)
      return too_many(
          fmt::format("1000 impacts and changes of contact mode within {:.2g} s: they accumulate faster than "
                      "event-driven integration can resolve",
                      t - thousand_since_));
    thousand_since_ = t;
  }
  if (events_ % window != 0) return "";
  const double passed = t - window_since_;
  window_since_ = t;
  slow_windows_ = passed < 0.2 * time_scale_ ? slow_windows_ + 1 : 0;
  if (slow_windows_ < most) return "";
  return too_many(fmt::format(
      "the last {} impacts and changes of contact mode took {:.2g} s: {:.2g} per second are too many for "
      "event-driven integration",
      window, passed, static_cast<double>(window) / passed));
}

/// Modes that change repeatedly, faster than anything moves, are not a sequence of events.
std::string EventPace::mode_change(double t) {
  constexpr int most = 16;
  if (changes_ == 0 || t - changes_since_ > 1e-6 * time_scale_) {
    changes_ = 0;
    changes_since_ = t;
  }
  return ++changes_ < most ? ""
                           : too_many(fmt::format("the contact mode changes {} times at one instant", most));
}

/// The accumulation of impacts of one contact has an exactly known end; impacts that alternate
/// between several contacts may accumulate without one. The intervals of an accumulation shrink:
/// impacts that only follow each other often, as in pins of small clearance, are a sequence of events.
std::string EventPace::impact(double t, const std::vector<int>& approaching) {
  constexpr int most = 100;
  constexpr double shrunk = 0.1;
  const auto begin = [&] {
    impacts_ = 0;
    impacts_since_ = half_since_ = t;
    first_ = -1;
    several_ = false;
  };
  if (t - impacts_since_ > span_) begin();
  for (const int k : approaching) {
    if (first_ < 0) first_ = k;
    several_ = several_ || k != first_;
  }
  if (++impacts_ == most / 2) half_since_ = t;
  if (impacts_ < most) return "";
  const double passed = t - impacts_since_, last = t - half_since_;
  if (several_ && !(last > shrunk * (passed - last)))
    return too_many(fmt::format(
        "{} impacts of several contacts within {:.2g} s, the last half of them within {:.2g} s: they "
        "accumulate faster than event-driven integration can resolve",
        impacts_, passed, last));
  begin();
  return "";
}

void EventPace::restart() {
  events_ = impacts_ = changes_ = slow_windows_ = 0;
  first_ = -1;
  several_ = exceeded_ = false;
  thousand_since_ = window_since_ = impacts_since_ = half_since_ = changes_since_ = -INFINITY;
}

void EventFindings::add_notes(const System& system, double rounding, std::vector<std::string>& notes) const {
  const double scale = std::max(most_kinetic, 1e-300);
  if (lockups.count > 0)
    notes.push_back(diagnostic<Diagnostic::lockup>(lockups.count, lockups.energy / scale));
  if (unsolved.count > 0)
    notes.push_back(diagnostic<Diagnostic::unsolved_contacts>(unsolved.count, unsolved.energy / scale));
  if (inelastic.count > 0)
    notes.push_back(
        diagnostic<Diagnostic::no_restitution_impacts>(inelastic.count, inelastic.energy / scale));
  if (unloaded.count > 0)
    notes.push_back(diagnostic<Diagnostic::unloaded_contact>(
        unloaded.t, system.contact_facts(unloaded.contact).name,
        unloaded.count == 1 ? "an unloaded contact" : fmt::format("{} unloaded contacts", unloaded.count),
        unloaded.gap));
  if (merged > 1e3 * rounding) notes.push_back(diagnostic<Diagnostic::simultaneous_impacts>(1e6 * merged));
}

}  // namespace freeplay
