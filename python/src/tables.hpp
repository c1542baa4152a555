// Tables of a run in memory for pandas: the rows of trajectory.csv, forces.csv, events.csv and
// signals.csv, computed by the same arithmetic as the files.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "simulation/observer.hpp"
#include "simulation/table_rows.hpp"

namespace freeplay::python {

/// Column names, and the numbers in row-major order.
struct Table {
  std::vector<std::string> names;
  std::vector<double> numbers;
  std::size_t rows() const { return names.empty() ? 0 : numbers.size() / names.size(); }
  void add(std::span<const double> row) { numbers.insert(numbers.end(), row.begin(), row.end()); }
};

/// A column of words: each distinct word is stored once.
struct Words {
  std::vector<std::string> names;
  std::vector<std::int32_t> codes;  ///< index into `names`, one per row
  void add(const std::string& word);

 private:
  std::map<std::string, std::int32_t> known_;
};

class TrajectoryTable final : public Observer, RowSink {
 public:
  Table table;
  void begin(const Layout& layout, const State& state) override;
  void step(const Step& step) override { rows_.step(step, *this); }

 private:
  void row(std::span<const double> numbers) override { table.add(numbers); }
  TrajectoryRows rows_;
};

class ForcesTable final : public Observer, RowSink {
 public:
  Table table;
  Wants wants() const override { return {.forces = true}; }
  void begin(const Layout& layout, const State& state) override;
  void step(const Step& step) override { rows_.step(step, *this); }

 private:
  void row(std::span<const double> numbers) override { table.add(numbers); }
  ForceRows rows_;
};

class EventsTable final : public Observer {
 public:
  Table table{{"t", "crank_angle", "v_n_minus", "v_n_plus", "v_t_minus", "v_t_plus", "impulse_n", "impulse_t",
               "duration", "t_uncertainty"},
              {}};
  Words joint, kind;
  Wants wants() const override { return {.steps = false}; }
  void event(const Event& event) override;
};

class SignalsTable final : public Observer {
 public:
  Table table{{"t", "crank_angle", "value"}, {}};
  Words channel;
  Wants wants() const override { return {.samples = true, .steps = false}; }
  void begin(const Layout& layout, const State& state) override;
  void sample(std::size_t channel, double t, double value) override;

 private:
  std::vector<std::string> names_;
  double crank_start_ = 0, crank_speed_ = 0;
};

}  // namespace freeplay::python
