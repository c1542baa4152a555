// From touches and losses of contact to events and modes, in the same way for both formulations. A contact
// that ends within its `limit` was an impact; one that outlasts it is lasting contact, reported by its
// beginning and its separation. The formulation sets the limit: four times the duration of the undamped Hertz
// impact (penalty), one step (time stepping).
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
  /// `reported`: behind the contacts those indices of families that pairs without a number are told by.
  explicit ContactLog(int contacts, int reported = 0);

  /// Room for pairs without a number, up to k.
  void make_room(int k) {
    if (k >= static_cast<int>(open_.size())) open_.resize(static_cast<std::size_t>(k) + 1);
  }
  /// Of a touch just logged: the family and bodies of a pair without a number.
  void name(int k, int family, const std::array<int, 2>& bodies) {
    open_[k].first.contact = family;
    open_[k].first.bodies = bodies;
  }

  /// First touch of contact k. All arguments as in ContactEvent.
  void touch(int k, double t, double crank_angle, double v_n, double v_t, double uncertainty, double limit);
  /// Loss of contact. `duration` may be zero for an impact law.
  void leave(int k, double t, double crank_angle, double v_n, double v_t, double impulse_n, double impulse_t,
             double duration);
  /// Time has come to t: contacts that have outlasted their limit become lasting.
  void advance(double t);
  bool is_open(int k) const { return open_[k].open; }

  /// Passes on the events whose order is settled, in the order of t, and forgets them.
  template <class Sink>
  void drain(Sink&& sink) {
    const std::size_t n = settled();
    for (std::size_t i = 0; i < n; ++i) sink(pending_[i]);
    pending_.erase(pending_.begin(), pending_.begin() + static_cast<long>(n));
  }
  bool has_pending() const { return !pending_.empty(); }
  /// Events that a touch before them, still undecided, holds back.
  std::span<const ContactEvent> held_back() const { return pending_; }
  /// When contact k was first touched, if it is open and not yet known to last (s), else NaN.
  double undecided_since(int k) const {
    return open_[k].open && !open_[k].lasting ? open_[k].first.t : __builtin_nan("");
  }

  template <class M>
  void remember(M& m) {
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
    void remember(M& m) {
      m(open, lasting, first, limit);
    }
  };
  void push(const ContactEvent& event);
  /// Throws MemoryError where what was read is of other contacts than these.
  void require(std::size_t contacts) const;
  std::size_t settled() const;

  int reported_ = 0, open_count_ = 0;
  std::vector<Episode> open_;
  std::vector<ContactEvent> pending_;  // in the order of t
};

}  // namespace freeplay
