// Observers that store trajectory, energies and events in memory.
#pragma once

#include <span>
#include <vector>

#include "simulation/observer.hpp"

namespace freeplay {

/// Multiples of a time step, each by its index, and the end of the scene's run. A multiple that
/// equals the end of a run up to rounding is replaced by the end: 20000·(0.03/20000) is greater
/// than 0.03.
class Grid {
 public:
  /// Starts after t; the caller makes a row at t. `step` (s) ≤ 0: no rows. `end` is the end of the
  /// run, `last` the end of the scene's run (s), which has a row even if it is no multiple.
  void begin(double t, double step, double end, double last);
  /// Continues with another run and its end.
  void go_on_to(double end) {
    end_ = end;
    if (step_ <= 0) return;
    if (beyond(index_ - 1)) --index_;  // its row is at the end of the scene's run
    next_ = multiple(index_);
  }
  /// s, time of the next row
  double next() const { return next_; }
  /// Goes on to the next row.
  void advance() { next_ = multiple(++index_); }
  template <class M>
  void serialize(M& m) {
    m(step_, next_, index_, end_, last_);
  }

 private:
  double rounding() const;
  /// Whether a multiple is the first one beyond the scene's end, which is not a multiple itself.
  bool beyond(long index) const;
  double multiple(long index) const;
  double step_ = 0, next_ = 0, end_ = 0, last_ = 0;
  long index_ = 0;
};

/// Rows of the state, at multiples of the scene's output step or of another step.
class Trajectory final : public Observer {
 public:
  Trajectory() = default;
  explicit Trajectory(double step) : step_(step) {}  ///< s

  /// Number of rows.
  std::size_t size() const { return t_.size(); }
  /// s, time of a row
  double t(std::size_t row) const { return t_[row]; }
  /// x, y, θ of each body (m, rad), and their rates.
  std::span<const double> q(std::size_t row) const { return {q_.data() + row * n_, n_}; }
  /// Velocities of a row (Layout::bodies × 3).
  std::span<const double> v(std::size_t row) const { return {v_.data() + row * n_, n_}; }

  void begin(const Layout& layout, const State& state) override;
  void step(const Step& step) override;

 private:
  double step_ = 0;
  std::size_t n_ = 0;
  Grid grid_;
  std::vector<double> t_, q_, v_;
};

/// Rows of the energy ledger, at the end of the first step after each multiple of the output step
/// or of another step.
class Energies final : public Observer {
 public:
  Energies() = default;
  explicit Energies(double step) : step_(step) {}  ///< s
  /// Energies at one time.
  struct Row {
    double t = 0;  ///< s
    /// J
    EnergyLedger ledger;
  };
  /// in the order of time
  std::vector<Row> rows;

  void begin(const Layout& layout, const State& state) override;
  void step(const Step& step) override;

 private:
  double step_ = 0;
  Grid grid_;
};

/// The first events, up to a number.
class EventList final : public Observer {
 public:
  /// Keeps the first `most` events.
  explicit EventList(std::size_t most) : most_(most) {}
  /// in the order of time
  std::vector<Event> events;
  /// number of all events
  long seen = 0;
  Wants wants() const override { return {.steps = false}; }
  void event(const Event& e) override;
  void save(MemoryWriter& m) override { m(events, seen); }
  void load(MemoryReader& m) override { m(events, seen); }

 private:
  std::size_t most_;
};

}  // namespace freeplay
