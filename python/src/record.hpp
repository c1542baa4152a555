// A run with all its tables in memory.
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <optional>

#include "facade/simulation.hpp"
#include "mechanism/scene.hpp"
#include "stop.hpp"
#include "tables.hpp"

namespace freeplay::python {

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
/// Adds derivatives, periodic motions, their branches and Lyapunov exponents.
void bind_motions(pybind11::module_& module);

}  // namespace freeplay::python
