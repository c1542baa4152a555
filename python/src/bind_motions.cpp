// Derivatives of runs, periodic motions, their branches, and Lyapunov exponents.
#include <pybind11/complex.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include "analysis/continuation.hpp"
#include "analysis/lyapunov.hpp"
#include "analysis/motion_documents.hpp"
#include "analysis/orbit.hpp"
#include "analysis/sensitivity.hpp"
#include "mechanism/error.hpp"
#include "record.hpp"
#include "stop.hpp"

namespace py = pybind11;

namespace freeplay::python {
namespace {

/// Calls work() without Python's lock. An interrupted call leaves a default result and sets the flag.
/// `pressed`: whether Ctrl-C was pressed.
template <class Work>
auto interruptible(StopFlag& flag, bool here, bool& pressed, const Work& work) {
  const UnderWay working;
  const py::gil_scoped_release unlocked;
  const CtrlC ctrl_c(flag, here);
  decltype(work()) result;
  try {
    result = work();
  } catch (const Interrupted&) {
    flag.requested = true;
  }
  pressed = ctrl_c.pressed();
  return result;
}

/// A document as values of Python.
py::dict result(const nlohmann::json& document, bool pressed) {
  auto d = object_of(document).cast<py::dict>();
  d["pressed"] = pressed;
  return d;
}

py::dict sensitivities_of(const Scene& scene, const std::vector<std::string>& of,
                          const std::vector<std::string>& to, const std::string& formulation, StopFlag& flag,
                          bool here) {
  bool pressed = false;
  const auto found = interruptible(flag, here, pressed, [&] {
    return sensitivities(scene, {.of = of, .to = to, .formulation = formulation, .stop = flag.token()});
  });
  return result(to_json(found, {}, formulation), pressed);
}

py::dict dict_of(const Orbit& o) {
  py::list impacts;
  for (const auto& i : o.impacts) impacts.append(py::make_tuple(i.t, i.joint, i.speed));
  py::dict d;
  d["period"] = o.period;
  d["periods"] = o.periods;
  d["residual"] = o.residual;
  d["t"] = o.state.t;
  d["q"] = o.state.q;
  d["v"] = o.state.v;
  d["impacts"] = impacts;
  d["multipliers"] = o.multipliers;
  d["stable"] = o.stable;
  d["step_error"] = o.step_error;
  d["shift"] = o.shift;
  d["failure"] = o.failure;
  return d;
}

py::dict orbit_of(const Scene& scene, const std::string& formulation, int periods, double settle,
                  std::optional<double> period, const std::vector<std::string>& shift, StopFlag& flag,
                  bool here) {
  bool pressed = false;
  const auto found = interruptible(flag, here, pressed, [&] {
    return orbit(scene, {.formulation = formulation,
                         .periods = periods,
                         .settle = settle,
                         .period = period,
                         .shift = shift,
                         .stop = flag.token()});
  });
  auto d = dict_of(found);
  d["pressed"] = pressed;
  return d;
}

/// The kinds of curves by their names.
std::vector<BifurcationKind> kinds_of(const std::vector<std::string>& names) {
  std::vector<BifurcationKind> kinds;
  for (const auto& name : names) {
    const auto known = std::ranges::find(bifurcation_names, name);
    const auto kind = static_cast<BifurcationKind>(known - bifurcation_names.begin());
    if (known == bifurcation_names.end() || kind >= BifurcationKind::sequence)
      throw ModelError("continue.curves",
                       "\"" + name + "\" is no kind of curve; use fold, flip, torus, grazing or liftoff");
    kinds.push_back(kind);
  }
  return kinds;
}

/// Key, range, greatest step and kinds of the curves over a second key.
using SecondOf = std::tuple<std::string, double, double, std::optional<double>, std::vector<std::string>>;

py::dict branches_of(const Scene& scene, const std::string& key, double from, double to,
                     std::optional<double> start, std::optional<double> step, int periods, double settle,
                     std::optional<double> period, int follow_doubled, int most_points,
                     const std::optional<SecondOf>& second, StopFlag& flag, bool here) {
  bool pressed = false;
  const auto found = interruptible(flag, here, pressed, [&] {
    ContinuationRequest request;
    request.key = key;
    request.from = from;
    request.to = to;
    request.start = start;
    request.step = step;
    request.periods = periods;
    request.settle = settle;
    request.period = period;
    request.follow_doubled = follow_doubled;
    request.most_points = most_points;
    if (second) {
      const auto& [name, first, last, longest, kinds] = *second;
      request.second =
          SecondKey{.key = name, .from = first, .to = last, .step = longest, .kinds = kinds_of(kinds)};
    }
    request.stop = flag.token();
    return continue_orbit(scene, request);
  });
  BranchTables tables(scene);
  py::list points;
  for (const auto& p : found.points) {
    auto d = dict_of(p.orbit);
    d["branch"] = p.branch;
    d["point"] = p.number;
    d["parameter"] = p.parameter;
    points.append(d);
  }
  tables.add(found);
  py::dict d;
  d["points"] = points;
  d["curve_points"] = object_of(tables.curves);
  d["curves"] = object_of(to_json(found.curves));
  d["bifurcations"] = object_of(tables.bifurcations);
  d["ends"] = object_of(to_json(found.ends));
  d["failure"] = found.failure;
  d["pressed"] = pressed;
  return d;
}

py::dict lyapunov_of(const Scene& scene, const std::string& formulation, int batches,
                     std::optional<double> transient, StopFlag& flag, bool here) {
  bool pressed = false;
  const auto found = interruptible(flag, here, pressed, [&] {
    return lyapunov(
        scene,
        {.formulation = formulation, .batches = batches, .transient = transient, .stop = flag.token()});
  });
  auto document = to_json(found, formulation);
  document["failure"] = found.failure;
  return result(document, pressed);
}

}  // namespace

void bind_motions(py::module_& m) {
  m.def("sensitivities_of", &sensitivities_of, py::arg("scene"), py::arg("of"), py::arg("to"),
        py::arg("formulation"), py::arg("flag"), py::arg("here"));
  m.def("orbit_of", &orbit_of, py::arg("scene"), py::arg("formulation"), py::arg("periods"),
        py::arg("settle"), py::arg("period"), py::arg("shift"), py::arg("flag"), py::arg("here"));
  m.def("branches_of", &branches_of, py::arg("scene"), py::arg("key"), py::arg("from_"), py::arg("to"),
        py::arg("start"), py::arg("step"), py::arg("periods"), py::arg("settle"), py::arg("period"),
        py::arg("follow_doubled"), py::arg("most_points"), py::arg("second"), py::arg("flag"),
        py::arg("here"));
  m.def("lyapunov_of", &lyapunov_of, py::arg("scene"), py::arg("formulation"), py::arg("batches"),
        py::arg("transient"), py::arg("flag"), py::arg("here"));
}

}  // namespace freeplay::python
