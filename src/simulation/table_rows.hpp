// Rows of a run's tables, for writing to files and for storing in memory: the trajectory, and the
// forces with their means since the previous row, at multiples of the output step.
#pragma once

#include <span>
#include <vector>

#include "simulation/columns.hpp"
#include "simulation/observer.hpp"
#include "simulation/trajectory.hpp"

namespace freeplay {

/// Receives rows as they are computed; the numbers are valid during the call only.
class RowSink {
 public:
  virtual void row(std::span<const double> numbers) = 0;

 protected:
  ~RowSink() = default;
};

/// Rows of trajectory_columns().
class TrajectoryRows {
 public:
  /// `fresh`: the start is the first row; otherwise a run is continued.
  void begin(const Layout& layout, const State& state, bool fresh, RowSink& sink);
  void step(const Step& step, RowSink& sink);
  double next() const { return grid_.next(); }  ///< s, time of the next row
  template <class M>
  void serialize(M& m) {
    m(grid_);
  }

 private:
  void row(double t, std::span<const double> q, std::span<const double> v,
           std::span<const ContactPlace> contacts, RowSink& sink);
  Grid grid_;
  std::vector<double> q_, v_, row_;
  std::vector<ContactPlace> contacts_;
};

/// Rows of force_columns().
class ForceRows {
 public:
  void begin(const Layout& layout, const State& state, bool fresh);
  void step(const Step& step, RowSink& sink);
  template <class M>
  void serialize(M& m) {
    m(grid_, since_, now_, sum_, started_);
  }

 private:
  void row(double t, const Forces& now, const Forces& sum, double share, RowSink& sink);
  std::vector<ForceParts> columns_;
  Grid grid_;
  double since_ = 0;  // s, of the last row
  Forces now_, sum_;
  bool started_ = false;  // whether the first row was written
  std::vector<double> row_;
};

}  // namespace freeplay
