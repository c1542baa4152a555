#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>
#include <nlohmann/json.hpp>

#include <memory>
#include <string>

#include "facade/law_plugin.hpp"
#include "io/files/digest.hpp"
#include "io/files/escaping.hpp"
#include "io/files/run_json.hpp"
#include "io/scene/read_scene.hpp"
#include "io/scene/write_scene.hpp"
#include "mechanism/outside.hpp"
#include "record.hpp"

namespace py = pybind11;

namespace freeplay::python {
namespace {

// Python functions as user-defined forces of a scene in memory.

/// A Python function owned by a law. A law may be destroyed in any thread, so the destructor
/// acquires the interpreter lock.
struct Function {
  explicit Function(py::function called) : f(std::move(called)) {}
  Function(const Function&) = delete;
  Function& operator=(const Function&) = delete;
  ~Function() {
    const py::gil_scoped_acquire locked;
    f = py::function();
  }
  py::function f;
};

double call(const void* context, const char* contact, double delta, double rate, double v0) {
  const py::gil_scoped_acquire locked;  // a run does not hold the lock
  return py::float_(static_cast<const Function*>(context)->f(contact, delta, rate, v0));
}

Vec2 call(const void* context, const char* load, double t, const Vec2& place, const Vec2& velocity) {
  const py::gil_scoped_acquire locked;
  const py::object found = static_cast<const Function*>(context)->f(
      t, py::make_tuple(place.x(), place.y()), py::make_tuple(velocity.x(), velocity.y()));
  if (!py::isinstance<py::sequence>(found) || py::len(found) != 2)
    throw py::type_error("the force of " + std::string(load) + " must be two numbers (N), is " +
                         std::string(py::repr(found)));
  const auto f = py::reinterpret_borrow<py::sequence>(found);
  return {py::float_(f[0]), py::float_(f[1])};
}

template <class Own>
std::shared_ptr<const Own> own_of(decltype(Own::force) force, const py::function& f, const std::string& name,
                                  const std::string& what) {
  return std::make_shared<const Own>(
      Own{force, std::make_shared<Function>(f), visible_brief(name), digest(what)});
}

/// Contact law from f(contact, penetration, rate, speed at contact onset), which returns N. `what`
/// is the text that identifies the function. Exceptions of f propagate out of the run.
std::shared_ptr<const OwnLaw> law_of(const py::function& f, const std::string& name,
                                     const std::string& what) {
  return own_of<OwnLaw>(call, f, name, what);
}

/// Force from f(t, place, velocity), which returns two numbers in N; place and velocity are tuples
/// of two.
std::shared_ptr<const OwnForce> force_of(const py::function& f, const std::string& name,
                                         const std::string& what) {
  return own_of<OwnForce>(call, f, name, what);
}

/// A NumPy array that shares the memory of a table; `owner` keeps the memory alive.
py::tuple shown(const MemoryTable& table, const py::object& owner) {
  const auto columns = static_cast<py::ssize_t>(table.names.size());
  const auto rows = static_cast<py::ssize_t>(table.rows());
  py::array_t<double> numbers({rows, columns}, table.numbers.data(), owner);
  return py::make_tuple(table.names, numbers);
}

py::tuple shown(const Words& words, const py::object& owner) {
  return py::make_tuple(words.names, py::array_t<std::int32_t>(static_cast<py::ssize_t>(words.codes.size()),
                                                               words.codes.data(), owner));
}

std::string text_of(const Record& record) {
  auto document = to_json(record.result);
  document["provenance"] = provenance(record.scene, record.identity);
  return document.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

void bind_scene(py::module_& m) {
  py::class_<Scene>(m, "Scene")
      .def_static("read", &read_scene, py::arg("file"), py::arg("overrides"), py::arg("outside"))
      .def_static("parse", &parse_scene, py::arg("text"), py::arg("name"), py::arg("overrides"),
                  py::arg("outside"))
      .def("set", py::overload_cast<const std::string&, const std::string&>(&Scene::set), py::arg("key"),
           py::arg("value"))
      .def(
          "take_function",
          [](Scene& scene, const py::function& f, const std::string& name, const std::string& what) {
            scene.penalty.own = law_of(f, name, what);
          },
          py::arg("function"), py::arg("name"), py::arg("what"))
      .def(
          "take_load",
          [](Scene& scene, const std::string& load, const py::function& f, const std::string& name,
             const std::string& what) {
            auto outside = outside_of(scene);
            outside.forces[load] = force_of(f, name, what);
            put(scene, outside);
          },
          py::arg("load"), py::arg("function"), py::arg("name"), py::arg("what"))
      .def(
          "take_plugin",
          [](Scene& scene, const std::filesystem::path& file) {
            const auto plugin = load_plugin(file);
            put(scene, plugin);
            return plugin.law != nullptr;
          },
          py::arg("file"))
      .def("copy", [](const Scene& scene) { return std::make_unique<Scene>(scene); })
      .def("canonical", [](const Scene& scene) { return to_toml(scene); })
      .def_property_readonly("text", [](const Scene& scene) { return scene.text; })
      .def_property_readonly("file", [](const Scene& scene) { return scene.file.string(); })
      .def_property_readonly("outside", [](const Scene& scene) { return scene.outside; })
      .def_property_readonly("idle", [](const Scene& scene) { return scene.idle; })
      .def_property_readonly("overrides", [](const Scene& scene) { return scene.overrides; });
}

void bind_record(py::module_& m) {
  py::class_<Record>(m, "Record")
      .def("info", &text_of)
      .def("trajectory",
           [](const py::object& self) { return shown(self.cast<const Record&>().trajectory, self); })
      .def("forces",
           [](const py::object& self) -> py::object {
             const auto& r = self.cast<const Record&>();
             if (!r.has_forces) return py::none();
             return shown(r.forces, self);
           })
      .def("events",
           [](const py::object& self) -> py::object {
             const auto& r = self.cast<const Record&>();
             if (!r.has_events) return py::none();
             return py::make_tuple(shown(r.events, self), shown(r.events.texts[0], self),
                                   shown(r.events.texts[1], self));
           })
      .def("signals",
           [](const py::object& self) -> py::object {
             const auto& r = self.cast<const Record&>();
             if (!r.has_signals) return py::none();
             return py::make_tuple(shown(r.signals, self), shown(r.signals.texts[0], self));
           })
      .def_property_readonly("formulation", [](const Record& r) { return r.result.formulation; })
      .def_property_readonly("status",
                             [](const Record& r) { return static_cast<int>(r.result.ending.status); })
      .def_property_readonly("reason", [](const Record& r) { return r.result.ending.reason; })
      .def_property_readonly("notes", [](const Record& r) { return r.result.notes; })
      .def_property_readonly("pressed", [](const Record& r) { return r.pressed; });
}

/// A simulation with the options from which it was made.
struct Live {
  Live(const Scene& scene, const std::string& formulation, bool is_matched, StopFlag& flag, bool here)
      : options{.matched = is_matched} {
    const UnderWay working;
    const py::gil_scoped_release unlocked;
    const CtrlC ctrl_c(flag, here);
    auto requested = options;
    requested.stop = flag.token();
    simulation =
        located_in(scene, [&] { return std::make_unique<Simulation>(scene, formulation, requested); });
  }
  SimulationOptions options;
  std::unique_ptr<Simulation> simulation;
  std::atomic<bool> running{false};
};

/// Guards against use by two threads at a time.
class Alone {
 public:
  explicit Alone(std::atomic<bool>& running) : running_(running) {
    if (running_.exchange(true))
      throw std::runtime_error(
          "this simulation is running, in another thread or around this observer; make one for each");
  }
  ~Alone() { running_ = false; }

 private:
  std::atomic<bool>& running_;
};

py::array_t<double> array(const std::vector<double>& list) {
  return py::array_t<double>(static_cast<py::ssize_t>(list.size()), list.data());
}

void bind_simulation(py::module_& m) {
  py::class_<StopFlag, std::shared_ptr<StopFlag>>(m, "StopFlag")
      .def(py::init<>())
      .def("set", [](StopFlag& flag) { flag.requested = true; })
      .def("is_set", [](const StopFlag& flag) { return flag.requested.load(); });
  py::class_<Live>(m, "Simulation")
      .def(py::init<const Scene&, const std::string&, bool, StopFlag&, bool>(), py::arg("scene"),
           py::arg("formulation"), py::arg("matched"), py::arg("flag"), py::arg("here"))
      .def(
          "run",
          [](Live& self, std::optional<double> until, py::object on_event, py::object on_row,
             const std::shared_ptr<StopFlag>& flag, bool here, bool companion) {
            const Alone alone(self.running);
            return record(*self.simulation, self.options, until, {std::move(on_event), std::move(on_row)},
                          *flag, here, companion);
          },
          py::arg("until"), py::arg("on_event"), py::arg("on_row"), py::arg("flag"), py::arg("here"),
          py::arg("companion"))
      .def("state",
           [](const Live& self) {
             const auto s = self.simulation->state();
             return py::make_tuple(s.t, array(s.q), array(s.v));
           })
      .def(
          "snapshot",
          [](Live& self, const std::filesystem::path& file) {
            const Alone alone(self.running);
            self.simulation->snapshot().write(file);
          },
          py::arg("file"))
      .def(
          "restore",
          [](Live& self, const std::filesystem::path& file) {
            const Alone alone(self.running);
            self.simulation->restore(Snapshot::read(file));
          },
          py::arg("file"));
}

}  // namespace

void bind_runs(py::module_& m) {
  bind_scene(m);
  bind_record(m);
  bind_simulation(m);
}

}  // namespace freeplay::python
