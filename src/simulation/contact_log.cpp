#include "simulation/contact_log.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace freeplay {

const char* name_of(EventKind kind) {
  switch (kind) {
    case EventKind::impact:
      return "impact";
    case EventKind::contact:
      return "contact";
    case EventKind::separation:
      return "separation";
  }
  throw std::logic_error("no such kind of event");
}

ContactLog::ContactLog(int contacts, int reported)
    : reported_(std::max(contacts, reported)), open_(contacts) {
  pending_.reserve(256);
}

void ContactLog::push(const ContactEvent& event) {
  const auto place = std::ranges::upper_bound(pending_, event.t, {}, &ContactEvent::t);
  pending_.insert(place, event);
}

void ContactLog::record_onset(int k, double t, double crank_angle, double v_n, double v_t, double uncertainty,
                              double limit) {
  auto& episode = open_[k];
  episode = {true, false, {}, limit};
  episode.first.t = t;
  episode.first.contact = k;
  episode.first.crank_angle = crank_angle;
  episode.first.v_n_minus = v_n;
  episode.first.v_t_minus = v_t;
  episode.first.t_uncertainty = uncertainty;
  ++open_count_;
}

void ContactLog::advance(double t) {
  if (open_count_ == 0) return;
  for (auto& episode : open_) {
    if (!episode.open || episode.lasting || t - episode.first.t <= episode.limit) continue;
    episode.lasting = true;
    episode.first.kind = EventKind::contact;
    push(episode.first);
  }
}

void ContactLog::record_separation(int k, double t, double crank_angle, double v_n, double v_t,
                                   double impulse_n, double impulse_t, double duration) {
  auto& episode = open_[k];
  if (!episode.open) return;
  episode.open = false;
  --open_count_;
  ContactEvent event = episode.first;
  event.v_n_plus = v_n;
  event.v_t_plus = v_t;
  event.impulse_n = impulse_n;
  event.impulse_t = impulse_t;
  event.duration = duration;
  if (episode.lasting) {
    event.kind = EventKind::separation;
    event.t = t;
    event.crank_angle = crank_angle;
    event.v_n_minus = event.v_t_minus = 0;
  } else {
    event.kind = EventKind::impact;
  }
  push(event);
}

/// Events before the first unclassified contact are final.
std::size_t ContactLog::settled() const {
  if (open_count_ == 0) return pending_.size();
  double first = INFINITY;
  for (const auto& episode : open_)
    if (episode.open && !episode.lasting) first = std::min(first, episode.first.t);
  std::size_t n = 0;
  while (n < pending_.size() && pending_[n].t <= first) ++n;
  return n;
}

void ContactLog::require(std::size_t contacts) const {
  const auto known = [&](const ContactEvent& e) {
    return static_cast<unsigned>(e.contact) < static_cast<unsigned>(reported_);
  };
  const bool events = std::ranges::all_of(pending_, known) &&
                      std::ranges::all_of(open_, [&](const Episode& e) { return !e.open || known(e.first); });
  const bool fits =
      reported_ > static_cast<int>(contacts) ? open_.size() >= contacts : open_.size() == contacts;
  if (!fits || !events) throw MemoryError("the snapshot's events belong to another mechanism");
}

}  // namespace freeplay
