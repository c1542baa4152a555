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
#pragma once

#include <cmath>
#include <vector>

#include "simulation/occasional.hpp"
#include "simulation/statistics.hpp"

namespace freeplay {

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
