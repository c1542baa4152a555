#include "sim/contact_log.hpp"

#include <algorithm>
#include <cmath>

namespace freeplay {

const char* name_of(EventKind kind) {
  switch (kind) {
    case EventKind::impact:
      return "impact";
    case EventKind::contact:
      return "contact";
    default:
      return "separation";
  }
}

int LogHistogram::bin(double x) {
  const int b = static_cast<int>(std::floor((std::log10(x) - lowest) * per_decade));
  return std::clamp(b, 0, per_decade * decades - 1);
}

void LogHistogram::add(double x) {
  if (!(x > 0)) return;
  ++count_[bin(x)];
  ++total_;
  greatest_ = std::max(greatest_, x);
}

long LogHistogram::at_least(double x) const {
  if (!(x > 0)) return total_;
  long sum = 0;
  for (int b = bin(x); b < per_decade * decades; ++b) sum += count_[b];
  return sum;
}

double LogHistogram::quantile(double p) const {
  long below = 0;
  for (int b = 0; b < per_decade * decades; ++b) {
    below += count_[b];
    if (below > 0 && static_cast<double>(below) >= p * static_cast<double>(total_))
      return std::pow(10, lowest + (b + 0.5) / per_decade);
  }
  return 0;
}

ContactLog::ContactLog(int contacts, double discard)
    : discard_(discard),
      open_(contacts),
      tallies_(contacts),
      ended_lasting_(contacts),
      ended_impacts_(contacts) {
  pending_.reserve(256);
}

void ContactLog::push(const ContactEvent& event) {
  const auto place = std::ranges::upper_bound(pending_, event.t, {}, &ContactEvent::t);
  pending_.insert(place, event);
}

void ContactLog::touch(int k, double t, double crank_angle, double v_n, double v_t, double uncertainty,
                       double limit) {
  auto& episode = open_[k];
  episode = {true, false, {}, limit};
  episode.first.t = t;
  episode.first.joint = k;
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

void ContactLog::leave(int k, double t, double crank_angle, double v_n, double v_t, double impulse_n,
                       double impulse_t, double duration) {
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
  const double counted = std::max(0.0, t - std::max(discard_, episode.first.t));
  if (episode.lasting) {
    event.kind = EventKind::separation;
    event.t = t;
    event.crank_angle = crank_angle;
    event.v_n_minus = event.v_t_minus = 0;
    ended_lasting_[k] += counted;
  } else {
    event.kind = EventKind::impact;
    if (event.t >= discard_) {
      ended_impacts_[k] += duration;
      tallies_[k].approach.add(-event.v_n_minus);
      tallies_[k].impulse.add(event.impulse_n);
    }
  }
  push(event);
}

/// Events before the first touch that is still undecided are settled.
std::size_t ContactLog::settled() const {
  if (open_count_ == 0) return pending_.size();
  double first = INFINITY;
  for (const auto& episode : open_)
    if (episode.open && !episode.lasting) first = std::min(first, episode.first.t);
  std::size_t n = 0;
  while (n < pending_.size() && pending_[n].t <= first) ++n;
  return n;
}

void ContactLog::tally_until(double t) {
  for (std::size_t k = 0; k < open_.size(); ++k) {
    const auto& episode = open_[k];
    tallies_[k].time = std::max(0.0, t - discard_);
    tallies_[k].lasting_time = ended_lasting_[k];
    tallies_[k].impact_time = ended_impacts_[k];
    if (episode.open)  // not yet known to last: an impact so far
      (episode.lasting ? tallies_[k].lasting_time : tallies_[k].impact_time) +=
          std::max(0.0, t - std::max(discard_, episode.first.t));
  }
}

}  // namespace freeplay
