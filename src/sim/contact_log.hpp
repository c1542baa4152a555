// From touches and losses of contact to events and modes, in the same way for both formulations. A contact
// that ends within its `limit` was an impact; one that outlasts it is lasting contact, reported by its
// beginning and its separation. The formulation sets the limit: four times the duration of the undamped Hertz
// impact (penalty), one step (time stepping).
#pragma once

#include <array>
#include <vector>

namespace freeplay {

enum class EventKind { impact, contact, separation };
const char* name_of(EventKind kind);

/// One line of events.csv.
struct ContactEvent {
  double t = 0;  ///< s, of first touch; for a separation of the loss
  int joint = 0;
  EventKind kind = EventKind::impact;
  double crank_angle = 0;               ///< rad, at t
  double v_n_minus = 0, v_n_plus = 0;   ///< m/s, rate of the gap before and after
  double v_t_minus = 0, v_t_plus = 0;   ///< m/s, sliding
  double impulse_n = 0, impulse_t = 0;  ///< N s
  double duration = 0;                  ///< s
  double t_uncertainty = 0;             ///< s
};

/// Counts by decades of a positive quantity, 20 bins each; the memory does not grow.
class LogHistogram {
 public:
  void add(double x);
  long total() const { return total_; }
  double greatest() const { return greatest_; }
  /// How many were at least x (to the width of a bin).
  long at_least(double x) const;
  /// The value below which a share p of all lie; 0 when empty.
  double quantile(double p) const;

 private:
  static constexpr int per_decade = 20, lowest = -15, decades = 25;
  static int bin(double x);
  std::array<long, per_decade * decades> count_{};
  long total_ = 0;
  double greatest_ = 0;
};

/// Modes and impacts of one contact after the discarded start.
struct ContactTally {
  double time = 0;          ///< s, observed
  double lasting_time = 0;  ///< s, in lasting contact
  double impact_time = 0;   ///< s, within impacts
  LogHistogram approach;    ///< m/s, of impacts
  LogHistogram impulse;     ///< N s, of impacts
};

class ContactLog {
 public:
  ContactLog() = default;
  /// `discard`: s left out of the tallies.
  ContactLog(int contacts, double discard);

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
  /// Brings the tallies up to t; contacts still open are counted so far.
  void tally_until(double t);
  const ContactTally& tally(int k) const { return tallies_[k]; }

 private:
  struct Episode {
    bool open = false, lasting = false;
    ContactEvent first;
    double limit = 0;
  };
  void push(const ContactEvent& event);
  std::size_t settled() const;

  double discard_ = 0;
  int open_count_ = 0;
  std::vector<Episode> open_;
  std::vector<ContactTally> tallies_;
  std::vector<double> ended_lasting_, ended_impacts_;  // s, of contacts that have ended
  std::vector<ContactEvent> pending_;                  // in the order of t
};

}  // namespace freeplay
