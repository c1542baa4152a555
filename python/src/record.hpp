// A run with all its tables in memory.
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <nlohmann/json_fwd.hpp>

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "facade/simulation.hpp"
#include "mechanism/scene.hpp"
#include "simulation/table_rows.hpp"
#include "stop.hpp"
#include "values/table.hpp"

namespace freeplay::python {

// Tables of a run in memory for pandas: the rows of trajectory.csv, forces.csv, events.csv and
// signals.csv, computed by the same arithmetic as the files. Tables and documents of other results as
// values of Python.

/// A column of words: each distinct word is stored once.
struct Words {
  std::vector<std::string> names;
  std::vector<std::int32_t> codes;  ///< index into `names`, one per row
  void add(std::string_view word);

 private:
  std::map<std::string, std::int32_t, std::less<>> known_;
};

/// A table: its columns of numbers in row-major order, and its columns of texts.
class MemoryTable : public TableSink {
 public:
  std::vector<std::string> names;  ///< of the columns of numbers
  std::vector<double> numbers;
  std::vector<Words> texts;
  std::size_t rows() const { return names.empty() ? 0 : numbers.size() / names.size(); }
  void put(std::span<const double> row, std::span<const std::string_view> words) override;

 private:
  void head() override;
};

/// A list for each column, by its name.
pybind11::dict object_of(const Table& table);
/// Dicts, lists and values. Numbers keep NaN and infinity, which a file has as null.
pybind11::object object_of(const nlohmann::json& document);

struct Watchers {
  pybind11::object on_event, on_row;  ///< callables or None
};

struct Record {
  Scene scene;
  Identity identity;
  Result result;
  RowsInto<TrajectoryRows, MemoryTable> trajectory;
  RowsInto<ForceRows, MemoryTable> forces;
  RowsInto<EventRows, MemoryTable> events;
  RowsInto<SignalRows, MemoryTable> signals;
  bool has_forces = false, has_events = false, has_signals = false;
  bool pressed = false;  ///< Ctrl-C ended the run
};

/// Continues a simulation and records its tables. The interpreter lock is released during the run
/// and acquired for calls of Python observers. `here`: whether this is the main thread.
/// `companion`: adds the companion run as `freeplay run` does.
std::unique_ptr<Record> record(Simulation& simulation, const SimulationOptions& options,
                               std::optional<double> until, const Watchers& watchers, StopFlag& flag,
                               bool here, bool companion);

/// Adds Scene, Record, Simulation and StopFlag to the module.
void bind_runs(pybind11::module_& module);
/// Adds check, compare, sweep and runs that write a result folder.
void bind_studies(pybind11::module_& module);
/// Adds derivatives, periodic motions, their branches, Lyapunov exponents and output play.
void bind_motions(pybind11::module_& module);

}  // namespace freeplay::python
