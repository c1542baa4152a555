// Statistics of contacts from their events: times of flight, impacts and lasting contact; approach
// speeds and impulses. ContactStatistics is an observer; into() writes its values to the contacts
// of a Result.
#pragma once

#include <array>
#include <cmath>
#include <vector>

#include "simulation/observer.hpp"
#include "values/result.hpp"

namespace freeplay {

/// Histogram of a positive quantity with 20 bins per decade; its memory is constant.
class LogHistogram {
 public:
  /// Counts a value.
  void add(double x);
  /// Number of values.
  long total() const { return total_; }
  /// Greatest value; 0 without values.
  double greatest() const { return greatest_; }
  /// The p-quantile; 0 if the histogram is empty.
  double quantile(double p) const;
  template <class M>
  void serialize(M& m) {
    m(count_, total_, greatest_);
  }

 private:
  static constexpr int per_decade = 20, lowest = -15, decades = 25;
  static int bin(double x);
  std::array<long, per_decade * decades> count_{};
  long total_ = 0;
  double greatest_ = 0;
};

/// Positive values of at least a tenth of the greatest one. Smaller values are dropped, because the
/// greatest never decreases. Up to `most` values are stored exactly. Beyond that, neighbours are
/// merged in pairs to their mean: memory is bounded, and a count may be wrong by a few of `most`.
class FastOnes {
 public:
  /// most values that are stored exactly
  static constexpr std::size_t most = 512;
  /// Allocates the memory; otherwise the first value does.
  void reserve() { kept_.reserve(most); }
  /// Adds a value.
  void add(double x) { add(x, 1); }
  /// The number of values of at least x, where x is at least a tenth of the greatest value.
  long at_least(double x) const;
  /// Greatest value; 0 without values.
  double greatest() const { return greatest_; }
  /// Adds the values of another object.
  void add(const FastOnes& other);
  template <class M>
  void serialize(M& m) {
    m(kept_, greatest_);
    if constexpr (M::reading) reserve();
  }

 private:
  struct Kept {
    double value;
    long count;
    template <class M>
    void serialize(M& m) {
      m(value, count);
    }
  };
  void add(double x, long count);

  std::vector<Kept> kept_;
  double greatest_ = 0;
};

/// Durations and impacts of one contact after the discarded start.
struct ContactTally {
  double time = 0;          ///< s, observed
  double lasting_time = 0;  ///< s, in lasting contact
  double impact_time = 0;   ///< s, in impacts
  LogHistogram approach;    ///< m/s, of impacts
  FastOnes fast;            ///< m/s, approach speeds of at least a tenth of the fastest
  LogHistogram impulse;     ///< N s, of impacts
  /// N s², sums of impulse times duration and of impulse times preceding flight, over impacts after
  /// a flight between two contacts
  double in_impact = 0, flown = 0;
  template <class M>
  void serialize(M& m) {
    m(time, lasting_time, impact_time, approach, fast, impulse, in_impact, flown);
  }
};

/// Statistics of all contacts of a run.
class ContactStatistics final : public Observer {
 public:
  /// `discard` (s): excluded start.
  explicit ContactStatistics(double discard) : discard_(discard) {}
  /// The tallies at the end of the last run; contacts that are still closed count up to the end.
  const std::vector<ContactTally>& tallies() const { return at_end_; }

  /// Writes the statistics into a result.
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
  std::size_t contacts_ = 0;  // indices from here on are families
  std::vector<ContactTally> tallies_, at_end_;
  std::vector<double> since_;  // s, onset of the present lasting contact; NaN: none
  std::vector<double> left_;   // s, end of the last contact; NaN: none yet
};

// Statistics with standard errors by batch means (Law, Simulation Modeling and Analysis, ch. 9).
// The observed time is divided into equal batches, whose scatter gives the error of the mean. A
// batch is one revolution, or a sixteenth of the observed time if no drive prescribes a speed. If
// there are more batches than can be stored, they are merged in pairs. With n complete batches of
// mean x_i
//
//     standard error of the mean = √(Σ (x_i − x̄)²/(n (n − 1))),   given for n ≥ 4.
//
// Batches are assumed to be independent. If the motion is correlated over more than one batch, the
// true error is greater.

/// Statistics of a run's window with standard errors.
class WindowStatistics final : public Observer, public Occasional {
 public:
  static constexpr int fewest = 4;  ///< batches needed for a standard error
  static constexpr int most = 16;   ///< batches stored

  /// `discard` (s): excluded start; `end` (s): end of the whole run.
  WindowStatistics(double discard, double end) : discard_(discard), end_(end) {}

  /// Writes the window, its energies and the standard errors; ContactStatistics writes the mean
  /// values.
  void into(Result& result) const;

  double next() const override { return std::isnan(before_.t) ? -INFINITY : start_of(marks_.size()); }

  void begin(const Layout& layout, const State& state) override;
  void step(const Step& step) override;
  void event(const Event& event) override { count(event, batches_, since_); }
  void end(const RunEnd& end) override;
  void save(MemoryWriter& m) override { serialize(m); }
  void load(MemoryReader& m) override { serialize(m); }

 private:
  /// Contribution of one contact to a batch.
  struct Part {
    double lasting_time = 0, impact_time = 0;  // s
    FastOnes approach;                         // m/s, of impacts
    void add(const Part& other);
    template <class M>
    void serialize(M& m) {
      m(lasting_time, impact_time, approach);
    }
  };
  using Batch = std::vector<Part>;  // of each contact
  /// The ledger at the beginning of a batch, interpolated linearly in time within its step.
  struct Mark {
    double t = 0;
    EnergyLedger ledger;
    template <class M>
    void serialize(M& m) {
      m(t, ledger);
    }
  };
  template <class M>
  void serialize(M& m) {
    m(length_, batches_, marks_, before_, since_);
  }
  double start_of(std::size_t batch) const { return discard_ + length_ * static_cast<double>(batch); }
  void join();
  void fit(double t);
  void count(const ContactEvent& e, std::vector<Batch>& batches, std::vector<double>& since);
  /// Adds the part of [from, to] in each batch to the lasting or impact time of that batch.
  void spread(double from, double to, int contact, double Part::*time, std::vector<Batch>& batches);

  double discard_, end_, length_ = 0;
  std::vector<Batch> batches_, at_end_;
  std::vector<Mark> marks_;
  Mark before_{NAN, {}};       // end of the last step
  std::vector<double> since_;  // s, onset of the present lasting contact; NaN: none
};

}  // namespace freeplay
