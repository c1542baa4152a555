// Statistics of contacts from their events: how long they flew, struck and lasted, how fast and how hard.
#pragma once

#include <array>
#include <cmath>
#include <vector>

#include "simulation/observer.hpp"
#include "values/result.hpp"

namespace freeplay {

/// Counts by decades of a positive quantity, 20 bins each; the memory does not grow.
class LogHistogram {
 public:
  void add(double x);
  long total() const { return total_; }
  double greatest() const { return greatest_; }
  /// The value below which a share p of all lie; 0 when empty.
  double quantile(double p) const;
  /// Takes over what another has counted.
  void add(const LogHistogram& other);
  template <class M>
  void remember(M& m) {
    m(count_, total_, greatest_);
  }

 private:
  static constexpr int per_decade = 20, lowest = -15, decades = 25;
  static int bin(double x);
  std::array<long, per_decade * decades> count_{};
  long total_ = 0;
  double greatest_ = 0;
};

/// The values among positive ones that are at least a tenth of the greatest; what is slower can never count again. Each is kept
/// as it is while there are no more than `most`; beyond that neighbours are joined to their mean, two by two, so that memory is bound
/// and a count is off by a few of `most`.
class FastOnes {
 public:
  static constexpr std::size_t most = 512;
  /// Takes its room; without it the first value does.
  void reserve() { kept_.reserve(most); }
  void add(double x) { add(x, 1); }
  /// How many were at least x, which is at least a tenth of the greatest.
  long at_least(double x) const;
  double greatest() const { return greatest_; }
  void add(const FastOnes& other);
  template <class M>
  void remember(M& m) {
    m(kept_, greatest_);
    if constexpr (M::reading) reserve();
  }

 private:
  struct Kept {
    double value;
    long count;
    template <class M>
    void remember(M& m) {
      m(value, count);
    }
  };
  void add(double x, long count);

  std::vector<Kept> kept_;
  double greatest_ = 0;
};

/// Modes and impacts of one contact after the discarded start.
struct ContactTally {
  double time = 0;          ///< s, observed
  double lasting_time = 0;  ///< s, in lasting contact
  double impact_time = 0;   ///< s, within impacts
  LogHistogram approach;    ///< m/s, of impacts
  FastOnes fast;            ///< m/s, the same from a tenth of the fastest on
  LogHistogram impulse;     ///< N s, of impacts
  /// N s², impulse times duration and impulse times the flight before, of impacts that a flight between two
  /// contacts led to
  double struck = 0, flown = 0;
  template <class M>
  void remember(M& m) {
    m(time, lasting_time, impact_time, approach, fast, impulse, struck, flown);
  }
};

class ContactStatistics final : public Observer {
 public:
  /// `discard`: s left out.
  explicit ContactStatistics(double discard) : discard_(discard) {}
  /// Of the last run that ended, contacts still open counted so far.
  const std::vector<ContactTally>& tallies() const { return at_end_; }

  /// Puts them into a result.
  void into(Result& result) const;

  Wants wants() const override { return {.steps = false}; }
  void begin(const Layout& layout, const State& state) override;
  void event(const Event& event) override { count(event, tallies_, since_, left_); }
  void end(const RunEnd& end) override;
  void save(MemoryWriter& m) override { m(tallies_, since_, left_); }
  void load(MemoryReader& m) override { m(tallies_, since_, left_); }

 private:
  void count(const ContactEvent& event, std::vector<ContactTally>& tallies, std::vector<double>& since,
             std::vector<double>& left) const;

  double discard_;
  std::size_t contacts_ = 0;  // behind them families
  std::vector<ContactTally> tallies_, at_end_;
  std::vector<double> since_;  // s, beginning of the lasting contact; NaN: none
  std::vector<double> left_;   // s, end of the last contact; NaN: none yet
};

}  // namespace freeplay
