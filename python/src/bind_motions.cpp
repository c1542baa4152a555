// Derivatives of runs, periodic motions, their branches, and Lyapunov exponents.
#include <pybind11/complex.h>
#include <pybind11/stl.h>

#include "facade/continuation.hpp"
#include "facade/lyapunov.hpp"
#include "facade/orbit.hpp"
#include "facade/sensitivity.hpp"
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

py::dict sensitivities_of(const Scene& scene, const std::vector<std::string>& of,
                          const std::vector<std::string>& to, const std::string& formulation, StopFlag& flag,
                          bool here) {
  bool pressed = false;
  const auto found = interruptible(flag, here, pressed, [&] {
    return sensitivities(scene, {.of = of, .to = to, .formulation = formulation, .stop = flag.token()});
  });
  py::list names, values, derivatives, reasons;
  for (const auto& q : found.quantities) {
    names.append(q.name);
    values.append(q.value);
    derivatives.append(q.derivatives);
    reasons.append(q.reasons);
  }
  py::dict d;
  d["keys"] = found.keys;
  d["key_values"] = found.key_values;
  d["names"] = names;
  d["values"] = values;
  d["derivatives"] = derivatives;
  d["reasons"] = reasons;
  d["stopped"] = found.stopped;
  d["pressed"] = pressed;
  return d;
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

py::dict branches_of(const Scene& scene, const std::string& key, double from, double to,
                     std::optional<double> step, int periods, double settle, std::optional<double> period,
                     int follow_doubled, StopFlag& flag, bool here) {
  bool pressed = false;
  const auto found = interruptible(flag, here, pressed, [&] {
    ContinuationRequest request;
    request.key = key;
    request.from = from;
    request.to = to;
    request.step = step;
    request.periods = periods;
    request.settle = settle;
    request.period = period;
    request.follow_doubled = follow_doubled;
    request.stop = flag.token();
    return continue_orbit(scene, request);
  });
  py::list points, bifurcations, ends;
  for (const auto& p : found.points) {
    auto d = dict_of(p.orbit);
    d["branch"] = p.branch;
    d["point"] = p.number;
    d["parameter"] = p.parameter;
    points.append(d);
  }
  for (const auto& b : found.bifurcations)
    bifurcations.append(py::make_tuple(bifurcation_names[static_cast<std::size_t>(b.kind)], b.at.parameter,
                                       b.at.orbit.period, b.at.branch, b.joint, b.follows, b.new_branch));
  for (const auto& e : found.ends) ends.append(py::make_tuple(e.branch, e.points, e.begins, e.reason));
  py::dict d;
  d["points"] = points;
  d["bifurcations"] = bifurcations;
  d["ends"] = ends;
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
  py::list values, errors, reasons;
  for (const auto& e : found.exponents) {
    values.append(e.value);
    errors.append(e.error);
    reasons.append(e.reason);
  }
  py::dict d;
  d["values"] = values;
  d["errors"] = errors;
  d["reasons"] = reasons;
  d["sum"] = found.sum;
  d["sum_predicted"] = found.predicted;
  d["impacts"] = found.impacts;
  d["transient"] = found.transient;
  d["duration"] = found.duration;
  d["stopped"] = found.stopped;
  d["failure"] = found.failure;
  d["pressed"] = pressed;
  return d;
}

}  // namespace

void bind_motions(py::module_& m) {
  m.def("sensitivities_of", &sensitivities_of, py::arg("scene"), py::arg("of"), py::arg("to"),
        py::arg("formulation"), py::arg("flag"), py::arg("here"));
  m.def("orbit_of", &orbit_of, py::arg("scene"), py::arg("formulation"), py::arg("periods"),
        py::arg("settle"), py::arg("period"), py::arg("shift"), py::arg("flag"), py::arg("here"));
  m.def("branches_of", &branches_of, py::arg("scene"), py::arg("key"), py::arg("start"), py::arg("end"),
        py::arg("step"), py::arg("periods"), py::arg("settle"), py::arg("period"), py::arg("follow_doubled"),
        py::arg("flag"), py::arg("here"));
  m.def("lyapunov_of", &lyapunov_of, py::arg("scene"), py::arg("formulation"), py::arg("batches"),
        py::arg("transient"), py::arg("flag"), py::arg("here"));
}

}  // namespace freeplay::python
