// Classifies contact onsets and separations as events, in the same way for both formulations.
//
// A contact that ends within its `limit` is an impact. A longer one is a lasting contact, reported
// by its onset and its separation. The formulation sets the limit: four times the duration of the
// undamped Hertz impact (penalty), one step (time stepping). Events leave the log in the order of
// time; an event therefore waits until all earlier contacts are classified.
//
// Usage: record_onset(), record_separation(), advance() after each step, drain() to obtain
// the final events.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "values/event.hpp"
#include "values/memory.hpp"

namespace freeplay {

class ContactLog {
 public:
  ContactLog() = default;
  /// `reported`: number of contacts and families. Pairs without an index are reported with the
  /// index of their family, which is at least `contacts`.
  explicit ContactLog(int contacts, int reported = 0);

  /// Makes room for slots of pairs without an index, up to slot k.
  void make_room(int k) {
    if (k >= static_cast<int>(open_.size())) open_.resize(static_cast<std::size_t>(k) + 1);
  }
  /// Sets the family and bodies of the pair in slot k, just after its onset.
  void name(int k, int family, const std::array<int, 2>& bodies) {
    open_[k].first.contact = family;
    open_[k].first.bodies = bodies;
  }

  /// Onset of contact k. All arguments as in ContactEvent.
  void record_onset(int k, double t, double crank_angle, double v_n, double v_t, double uncertainty,
                    double limit);
  /// Separation of contact k. `duration` may be zero for an impact law.
  void record_separation(int k, double t, double crank_angle, double v_n, double v_t, double impulse_n,
                         double impulse_t, double duration);
  /// Classifies contacts that have lasted longer than their limit at time t as lasting.
  void advance(double t);
  bool is_open(int k) const { return open_[k].open; }

  /// Passes the final events to `sink` in the order of t and removes them.
  template <class Sink>
  void drain(Sink&& sink) {
    const std::size_t n = settled();
    for (std::size_t i = 0; i < n; ++i) sink(pending_[i]);
    pending_.erase(pending_.begin(), pending_.begin() + static_cast<long>(n));
  }
  bool has_pending() const { return !pending_.empty(); }
  /// Events that wait for an earlier contact, which is not yet classified.
  std::span<const ContactEvent> held_back() const { return pending_; }
  /// Onset time (s) of contact k if it is closed and not yet classified, else NaN.
  double undecided_since(int k) const {
    return open_[k].open && !open_[k].lasting ? open_[k].first.t : __builtin_nan("");
  }

  template <class M>
  void serialize(M& m) {
    const auto contacts = open_.size();
    m(open_count_, open_, pending_);
    if constexpr (M::reading) require(contacts);
  }

 private:
  struct Episode {
    bool open = false, lasting = false;
    ContactEvent first;
    double limit = 0;
    template <class M>
    void serialize(M& m) {
      m(open, lasting, first, limit);
    }
  };
  void push(const ContactEvent& event);
  /// Throws MemoryError if the restored data belong to other contacts.
  void require(std::size_t contacts) const;
  std::size_t settled() const;

  int reported_ = 0, open_count_ = 0;
  std::vector<Episode> open_;
  std::vector<ContactEvent> pending_;  // in the order of t
};

}  // namespace freeplay
