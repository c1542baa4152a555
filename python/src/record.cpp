#include "record.hpp"

#include "facade/companion.hpp"
#include "formulations/make.hpp"
#include "simulation/film_statistics.hpp"
#include "simulation/statistics.hpp"
#include "simulation/windows.hpp"

namespace py = pybind11;

namespace freeplay::python {
namespace {

/// Calls a Python function for each event. The run ends when the function returns True.
class EventCalls final : public Observer {
 public:
  EventCalls(const py::object& call, StopFlag& flag) : call_(call), flag_(flag) {}
  Wants wants() const override { return {.steps = false}; }
  void event(const Event& e) override {
    const py::gil_scoped_acquire lock;
    py::dict d;
    d["t"] = e.t;
    d["joint"] = e.joint;
    d["kind"] = name_of(e.kind);
    d["crank_angle"] = e.crank_angle;
    d["v_n_minus"] = e.v_n_minus;
    d["v_n_plus"] = e.v_n_plus;
    d["v_t_minus"] = e.v_t_minus;
    d["v_t_plus"] = e.v_t_plus;
    d["impulse_n"] = e.impulse_n;
    d["impulse_t"] = e.impulse_t;
    d["duration"] = e.duration;
    d["t_uncertainty"] = e.t_uncertainty;
    if (call_(d).is(py::bool_(true))) flag_.requested = true;
  }

 private:
  const py::object& call_;
  StopFlag& flag_;
};

/// Calls a Python function for each row of the trajectory. The run ends when the function returns
/// True.
class RowCalls final : public Observer, RowSink {
 public:
  RowCalls(const py::object& call, StopFlag& flag) : call_(call), flag_(flag) {}
  void begin(const Layout& layout, const State& state) override {
    {
      const py::gil_scoped_acquire lock;
      for (const auto& c : trajectory_columns(layout)) names_.push_back(py::str(c.name()));
    }
    rows_.begin(layout, state, true, *this);
  }
  void step(const Step& step) override { rows_.step(step, *this); }
  /// Releases the names. Must be called with the interpreter lock held before destruction.
  void forget() { names_.clear(); }

 private:
  void row(std::span<const double> numbers) override {
    const py::gil_scoped_acquire lock;
    py::dict d;
    for (std::size_t i = 0; i < numbers.size(); ++i) d[names_[i]] = numbers[i];
    if (call_(d).is(py::bool_(true))) flag_.requested = true;
  }
  const py::object& call_;
  StopFlag& flag_;
  TrajectoryRows rows_;
  std::vector<py::str> names_;
};

}  // namespace

std::unique_ptr<Record> record(Simulation& simulation, const SimulationOptions& options,
                               std::optional<double> until, const Watchers& watchers, StopFlag& flag,
                               bool here, bool companion) {
  const UnderWay working;
  auto kept = std::make_unique<Record>();
  const auto& scene = simulation.scene();
  if (scene.run.forces) refuse_shared_names(simulation.layout());
  ContactStatistics statistics(scene.run.discard);
  WindowStatistics windows(scene.run.discard, scene.run.duration);
  std::optional<FilmStatistics> films;
  if (!scene.mechanism.lubricants.empty()) films.emplace(film_probe(scene), scene.run.discard);
  EventCalls event_calls(watchers.on_event, flag);
  RowCalls row_calls(watchers.on_row, flag);
  kept->has_forces = scene.run.forces;
  kept->has_events = !simulation.layout().contacts.empty();
  kept->has_signals = !simulation.layout().channels.empty();

  std::vector<Observer*> observers{&statistics, &windows, &kept->trajectory};
  if (films) observers.push_back(&*films);
  if (kept->has_events) observers.push_back(&kept->events);
  if (kept->has_signals) observers.push_back(&kept->signals);
  if (kept->has_forces) observers.push_back(&kept->forces);
  if (!watchers.on_event.is_none()) observers.push_back(&event_calls);
  if (!watchers.on_row.is_none()) observers.push_back(&row_calls);
  try {
    const py::gil_scoped_release unlocked;
    const CtrlC ctrl_c(flag, here);
    kept->result = simulation.run(
        {.until = until, .observers = std::move(observers), .most_events = 0, .stop = flag.token()});
    statistics.into(kept->result);
    windows.into(kept->result);
    if (films) films->into(kept->result);
    if (companion) add_companion(simulation, options, flag.token(), kept->result);
    kept->identity = simulation.identity();
    kept->scene = scene;
    kept->pressed = ctrl_c.pressed();
  } catch (...) {
    row_calls.forget();
    throw;
  }
  row_calls.forget();
  return kept;
}

}  // namespace freeplay::python
