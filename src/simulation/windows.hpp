// Statistics with their error: the observed time cut into equal batches, whose scatter says how well the mean is known
// (batch means: Law, Simulation Modeling and Analysis, ch. 9). A batch is one revolution, or a sixteenth of the
// observed time where nothing turns at a prescribed speed; when there are more than the memory holds they are joined
// two by two. With n whole batches of mean x_i
//
//     standard error of the mean = √(Σ (x_i − x̄)²/(n (n − 1))),   given from n = 4 on.
//
// Batches are taken as independent: of motion that remembers longer than one of them the true error is greater.
#pragma once

#include <cmath>
#include <vector>

#include "simulation/statistics.hpp"

namespace freeplay {

class WindowStatistics final : public Observer {
 public:
  static constexpr int fewest = 4;  ///< batches, for a standard error
  static constexpr int most = 16;   ///< kept

  /// `discard`: s left out; `end`: s, of the whole run.
  WindowStatistics(double discard, double end) : discard_(discard), end_(end) {}

  /// Window, energies in it and standard errors, beside the statistics that ContactStatistics puts there.
  void into(Result& result) const;

  void begin(const Layout& layout, const State& state) override;
  void step(const Step& step) override;
  void event(const Event& event) override { count(event, batches_, since_); }
  void end(const RunEnd& end) override;
  void save(MemoryWriter& m) override { remember(m); }
  void load(MemoryReader& m) override { remember(m); }

 private:
  /// What one contact did in a batch.
  struct Part {
    double lasting_time = 0, impact_time = 0;  // s
    FastOnes approach;                         // m/s, of impacts
    void add(const Part& other);
    template <class M>
    void remember(M& m) {
      m(lasting_time, impact_time, approach);
    }
  };
  using Batch = std::vector<Part>;  // of each contact
  /// The ledger at a batch's beginning, in proportion to time between the ends of the step that it lies in.
  struct Mark {
    double t = 0;
    EnergyLedger ledger;
    template <class M>
    void remember(M& m) {
      m(t, ledger);
    }
  };
  template <class M>
  void remember(M& m) {
    m(length_, batches_, marks_, before_, since_);
  }
  double start_of(std::size_t batch) const { return discard_ + length_ * static_cast<double>(batch); }
  void join();
  void fit(double t);
  void count(const ContactEvent& e, std::vector<Batch>& batches, std::vector<double>& since);
  /// Adds the part of [from, to] in each batch to its lasting or impact time.
  void spread(double from, double to, int contact, double Part::*time, std::vector<Batch>& batches);

  double discard_, end_, length_ = 0;
  std::vector<Batch> batches_, at_end_;
  std::vector<Mark> marks_;
  Mark before_{NAN, {}};       // the last step's end
  std::vector<double> since_;  // s, beginning of the lasting contact; NaN: none
};

}  // namespace freeplay
