// The tables of a run, row by row, for files, for memory and for functions of users: the trajectory,
// the forces with their means since the previous row (both at multiples of the output step), the
// events, and the samples of the instruments. An observer computes each row once; a TableSink
// receives it.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "simulation/observer.hpp"
#include "simulation/trajectory.hpp"

namespace freeplay {

/// The columns of a run's tables: names in trajectory.csv and forces.csv, and the place of each
/// value in the data that an observer receives. Writers, ensembles and studies all use these lists.
struct Column {
  /// mean: mean of a force since the previous row; acceleration: of a body
  enum class Of { time, position, velocity, contact, force, mean, acceleration };
  std::string owner;  ///< name of the body, contact, joint, drive or load; empty for t
  const char* part = "";
  Of of = Of::time;
  /// Index into q, v, Layout::contacts, Layout::forces or Forces::acceleration.
  std::size_t index = 0;
  double ContactPlace::*place = nullptr;
  double ElementForce::*force = nullptr;

  /// Name in a header: gudgeon.gap, gudgeon.fn, big_end.fx_mean, t.
  std::string name() const;
};

/// Columns of trajectory.csv, t first.
std::vector<Column> trajectory_columns(const Layout& layout);
/// Columns of forces.csv, t first.
std::vector<Column> force_columns(const Layout& layout);

/// The data of a run at one time, from which columns are read.
struct ColumnData {
  std::vector<double> q, v;
  std::vector<ContactPlace> contacts;
  Forces now, sum;  ///< forces, and their impulses since the previous row

  /// Sets the sizes.
  void begin(const Layout& layout, const State& state);
  /// Value of a column at the time t (s) of the data; of a mean, the impulse.
  double value(const Column& column, double t) const;
  /// Replaces `row` by the values of the columns.
  void row(const std::vector<Column>& columns, double t, std::vector<double>& row) const;
};

/// Throws ModelError if two elements have the same name, because columns of forces are found by
/// name.
void refuse_shared_names(const Layout& layout);

/// Columns of one element of forces.csv: values at an instant, and means.
struct ForceParts {
  std::vector<std::pair<const char*, double ElementForce::*>> now, mean;
};
ForceParts force_parts(ForceElement::Kind kind);

/// Name of a column of numbers or of texts.
struct ColumnName {
  std::string name;
  bool text = false;
};

/// Receives a table.
class TableSink {
 public:
  /// Begins the table, unless a continued run began it. Returns whether it is new.
  bool open(std::vector<ColumnName> columns);
  /// A row: the values of the columns of numbers, and those of the columns of texts. Both are valid
  /// during the call only.
  virtual void put(std::span<const double> numbers, std::span<const std::string_view> texts) = 0;
  /// @name State, for runs that are interrupted and resumed
  ///@{
  virtual void save_to(MemoryWriter&) {}
  virtual void load_from(MemoryReader&) {}
  ///@}

 protected:
  ~TableSink() = default;
  virtual void head() = 0;
  std::vector<ColumnName> columns_;
  bool fresh_ = true;  // whether the table has not been begun
};

/// Base of the observers that compute a table.
class RunRows : public Observer {
 public:
  explicit RunRows(TableSink& sink) : sink_(sink) {}
  void save(MemoryWriter& m) override { serialize(m); }
  void load(MemoryReader& m) override { serialize(m); }

 protected:
  /// The sink's state, and values of the observer.
  template <class M, class... T>
  void serialize(M& m, T&... values) {
    if constexpr (M::reading)
      sink_.load_from(m);
    else
      sink_.save_to(m);
    m(values...);
  }
  TableSink& sink_;
};

/// Rows of trajectory_columns().
class TrajectoryRows : public RunRows {
 public:
  using RunRows::RunRows;
  double next_row() const { return grid_.next(); }  ///< s, its time
  void begin(const Layout& layout, const State& state) override;
  void step(const Step& step) override;
  void save(MemoryWriter& m) override { serialize(m, grid_); }
  void load(MemoryReader& m) override { serialize(m, grid_); }

 private:
  Grid grid_;
  std::vector<Column> columns_;
  ColumnData data_;
  std::vector<double> row_;
};

/// Rows of force_columns().
class ForceRows : public RunRows {
 public:
  using RunRows::RunRows;
  Wants wants() const override { return {.forces = true}; }
  void begin(const Layout& layout, const State& state) override;
  void step(const Step& step) override;
  void save(MemoryWriter& m) override { serialize(m, grid_, since_, data_.now, data_.sum, started_); }
  void load(MemoryReader& m) override { serialize(m, grid_, since_, data_.now, data_.sum, started_); }

 private:
  void row(double t, const Forces& means, double share);
  std::vector<Column> columns_;
  Grid grid_;
  double since_ = 0;  // s, of the last row
  ColumnData data_;
  bool started_ = false;  // whether the first row was written
  std::vector<double> row_;
};

/// Contact events: t, joint, kind, and the numbers of an event.
class EventRows : public RunRows {
 public:
  using RunRows::RunRows;
  Wants wants() const override { return {.steps = false}; }
  void begin(const Layout& layout, const State& state) override;
  void event(const Event& event) override;
};

/// Samples of the instruments: channel, t, crank_angle, value.
class SignalRows : public RunRows {
 public:
  using RunRows::RunRows;
  Wants wants() const override { return {.samples = true, .steps = false}; }
  void begin(const Layout& layout, const State& state) override;
  void sample(std::size_t channel, double t, double value) override;

 private:
  std::vector<std::string> names_;
  double crank_start_ = 0, crank_speed_ = 0;
};

/// A table with the sink that receives it.
template <class Rows, class Sink>
class RowsInto : public Sink, public Rows {
 public:
  template <class... X>
  explicit RowsInto(X&&... x) : Sink(std::forward<X>(x)...), Rows(static_cast<TableSink&>(*this)) {}
};

}  // namespace freeplay
