#include "record.hpp"

#include <nlohmann/json.hpp>

#include "facade/assess.hpp"
#include "formulations/contact/steady_film.hpp"
#include "simulation/film_statistics.hpp"
#include "simulation/statistics.hpp"

namespace py = pybind11;

namespace freeplay::python {

void Words::add(std::string_view word) {
  auto at = known_.find(word);
  if (at == known_.end()) {
    at = known_.emplace(word, static_cast<std::int32_t>(names.size())).first;
    names.emplace_back(word);
  }
  codes.push_back(at->second);
}

void MemoryTable::head() {
  for (const auto& column : columns_)
    if (!column.text) names.push_back(column.name);
  texts.resize(columns_.size() - names.size());
}

void MemoryTable::put(std::span<const double> row, std::span<const std::string_view> words) {
  numbers.insert(numbers.end(), row.begin(), row.end());
  for (std::size_t i = 0; i < words.size(); ++i) texts[i].add(words[i]);
}

py::dict object_of(const Table& table) {
  py::dict columns;
  for (std::size_t i = 0; i < table.columns().size(); ++i) {
    py::list list;
    for (const auto& row : table.rows())
      list.append(std::visit([](const auto& x) -> py::object { return py::cast(x); }, row[i]));
    columns[py::str(table.columns()[i])] = list;
  }
  return columns;
}

py::object object_of(const nlohmann::json& j) {
  if (j.is_object()) {
    py::dict d;
    for (const auto& [key, value] : j.items()) d[py::str(key)] = object_of(value);
    return d;
  }
  if (j.is_array()) {
    py::list list;
    for (const auto& value : j) list.append(object_of(value));
    return list;
  }
  if (j.is_string()) return py::str(j.get_ref<const std::string&>());
  if (j.is_boolean()) return py::bool_(j.get<bool>());
  if (j.is_number_integer()) return py::int_(j.get<std::int64_t>());
  if (j.is_number()) return py::float_(j.get<double>());
  return py::none();
}

namespace {

/// Calls a Python function for each row of a table. The run ends when the function returns True.
class Calls : public TableSink {
 public:
  Calls(const py::object& call, StopFlag& flag) : call_(call), flag_(flag) {}
  /// Releases the names. Must be called with the interpreter lock held before destruction.
  void forget() { names_.clear(); }
  void put(std::span<const double> numbers, std::span<const std::string_view> texts) override {
    const py::gil_scoped_acquire lock;
    py::dict d;
    for (std::size_t i = 0, number = 0, text = 0; i < columns_.size(); ++i)
      if (columns_[i].text)
        d[names_[i]] = py::str(texts[text].data(), texts[text].size()), ++text;
      else
        d[names_[i]] = numbers[number++];
    if (call_(d).is(py::bool_(true))) flag_.requested = true;
  }

 private:
  void head() override {
    const py::gil_scoped_acquire lock;
    for (const auto& column : columns_) names_.push_back(py::str(column.name));
  }
  const py::object& call_;
  StopFlag& flag_;
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
  RowsInto<EventRows, Calls> event_calls(watchers.on_event, flag);
  RowsInto<TrajectoryRows, Calls> row_calls(watchers.on_row, flag);
  const auto forget = [&] {
    event_calls.forget();
    row_calls.forget();
  };
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
    forget();
    throw;
  }
  forget();
  return kept;
}

}  // namespace freeplay::python
