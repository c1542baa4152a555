// Derivatives of runs, periodic motions, their branches, Lyapunov exponents, and output play.
#include <pybind11/complex.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "analysis/continuation.hpp"
#include "analysis/lyapunov.hpp"
#include "analysis/motion_documents.hpp"
#include "analysis/orbit.hpp"
#include "analysis/play/play.hpp"
#include "analysis/play/play_allocation.hpp"
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

/// A number of each position; NaN where `of` has none.
template <class Of>
std::vector<double> over_positions(const Play& play, const Of& of) {
  std::vector<double> list;
  for (const auto& p : play.positions) list.push_back(of(p));
  return list;
}

/// A list of each position; empty where the range is refused.
template <class Of>
py::list lists_of(const Play& play, std::size_t k, const Of& of) {
  py::list list;
  for (const auto& p : play.positions) {
    if (p.refusal.empty())
      list.append(of(p.ranges[k]));
    else
      list.append(py::list());
  }
  return list;
}

/// The sums of a list of the components by joint.
std::vector<double> sums_of(const Play& play, const std::vector<double>& parts) {
  std::vector<double> list;
  for (const auto& part : by_joint(play, parts)) list.push_back(part.second);
  return list;
}

/// The ranges of quantity k.
py::dict range_of(const Play& play, std::size_t k) {
  py::dict d;
  d["name"] = play.quantities[k].name;
  d["unit"] = play.quantities[k].unit();
  for (const auto& [name, member] : {std::pair{"ideal", &PlayRange::ideal},
                                     {"linear", &PlayRange::linear},
                                     {"least", &PlayRange::least},
                                     {"greatest", &PlayRange::greatest},
                                     {"bound_least", &PlayRange::bound_least},
                                     {"bound_greatest", &PlayRange::bound_greatest}})
    d[name] = over_positions(
        play, [&, number = member](const auto& p) { return p.refusal.empty() ? p.ranges[k].*number : NAN; });
  std::vector<bool> settled;
  for (const auto& p : play.positions) settled.push_back(p.refusal.empty() && p.ranges[k].settled);
  d["settled"] = settled;
  d["parts"] = lists_of(play, k, [&](const PlayRange& r) { return py::cast(sums_of(play, r.parts)); });
  d["variance"] = lists_of(play, k, [&](const PlayRange& r) { return py::cast(sums_of(play, r.variance)); });
  d["at_least"] = lists_of(play, k, [](const PlayRange& r) { return py::cast(r.at_least); });
  d["at_greatest"] = lists_of(play, k, [](const PlayRange& r) { return py::cast(r.at_greatest); });
  if (play.sampled) {
    d["quantiles"] = lists_of(play, k, [](const PlayRange& r) { return py::cast(r.quantiles->value); });
    d["quantile_errors"] = lists_of(play, k, [](const PlayRange& r) { return py::cast(r.quantiles->error); });
  }
  if (play.loaded)
    for (const auto& [name, member] :
         {std::pair{"loaded_up", &PlayPosition::up}, {"loaded_down", &PlayPosition::down}})
      d[name] = over_positions(play, [&, side = member](const auto& p) {
        return (p.*side).failure.empty() ? (p.*side).values[k] : NAN;
      });
  return d;
}

/// The poses under the loads from one side.
py::dict loaded_of(const Play& play, LoadedPose PlayPosition::*side) {
  py::list poses, reactions, failures;
  for (const auto& p : play.positions) {
    const auto& pose = p.*side;
    poses.append(pose.failure.empty() ? pose.q : std::vector<double>());
    reactions.append(pose.failure.empty() ? pose.reactions : std::vector<double>());
    failures.append(pose.failure);
  }
  py::dict d;
  d["poses"] = poses;
  d["reactions"] = reactions;
  d["failures"] = failures;
  return d;
}

py::dict dict_of(const Play& play) {
  py::list ranges, clearances, joints, sources, poses, refusals, jumps, regions;
  for (std::size_t k = 0; k < play.quantities.size(); ++k) ranges.append(range_of(play, k));
  for (const auto& c : play.components)
    clearances.append(py::make_tuple(c.joint, c.part, c.disc ? "disc" : "two-sided", c.clearance));
  for (const auto& part : by_joint(play, std::vector<double>(play.components.size())))
    joints.append(part.first);
  for (const auto& part :
       by_joint(play, std::vector<double>(play.components.size() + play.tolerances.size())))
    sources.append(part.first);
  for (const auto& region : play.regions)
    for (const auto& place : region.farthest)
      regions.append(py::make_tuple(play.positions[region.position].coordinate, region.point, region.ideal_x,
                                    region.ideal_y, place.direction, place.x, place.y, place.bound));
  for (const auto& p : play.positions) poses.append(p.pose), refusals.append(p.refusal);
  for (const auto& jump : play.jumps) jumps.append(py::make_tuple(jump.joint, jump.from, jump.to, jump.up));
  py::dict d;
  d["joint"] = play.joint;
  d["unit"] = play.slides ? "m" : "rad";
  d["positions"] = over_positions(play, [](const auto& p) { return p.coordinate; });
  d["poses"] = poses;
  d["refusals"] = refusals;
  d["ranges"] = ranges;
  d["clearances"] = clearances;
  d["joints"] = joints;
  d["sources"] = sources;
  d["regions"] = regions;
  d["shares"] = play_shares;
  d["loaded"] = play.loaded;
  d["up"] = loaded_of(play, &PlayPosition::up);
  d["down"] = loaded_of(play, &PlayPosition::down);
  d["reactions"] = play.reactions;
  d["jumps"] = jumps;
  d["verdicts"] = verdicts(play);
  d["notes"] = play.notes;
  return d;
}

/// Joint, cost, exponent, least and greatest clearance.
using CostOf = std::tuple<std::string, double, double, double, double>;

py::dict play_of(const Scene& scene, const std::vector<std::string>& of, const std::string& over, double from,
                 double to, int points, bool loads, int samples, bool rim, std::optional<double> target,
                 const std::vector<CostOf>& costs, StopFlag& flag, bool here) {
  bool pressed = false;
  const auto found = interruptible(flag, here, pressed, [&] {
    PlayOptions options;
    options.quantities = of;
    options.over = over;
    options.from = from, options.to = to;
    options.points = points;
    options.loads = loads;
    options.sampling = {samples, rim ? PlayPlace::rim : PlayPlace::within};
    options.stop = flag.token();
    if (!target) return Allocation{.clearances = {}, .play = find_play(scene, options)};
    std::vector<ClearanceCost> list;
    for (const auto& [joint, cost, exponent, least, greatest] : costs)
      list.push_back({joint, cost, exponent, least, greatest});
    return allocate_clearances(scene, options, *target, list);
  });
  py::list allocated;
  for (const auto& c : found.clearances) {
    using Limit = AllocatedClearance::Limit;
    const char* limit = c.limit == Limit::least ? "least" : c.limit == Limit::greatest ? "greatest" : "";
    allocated.append(py::make_tuple(c.joint, c.before, c.after, c.cost, limit));
  }
  auto d = dict_of(found.play);
  d["allocation"] = allocated;
  d["pressed"] = pressed;
  return d;
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
  m.def("play_of", &play_of, py::arg("scene"), py::arg("of"), py::arg("over"), py::arg("from_"),
        py::arg("to"), py::arg("points"), py::arg("loads"), py::arg("samples"), py::arg("rim"),
        py::arg("target"), py::arg("costs"), py::arg("flag"), py::arg("here"));
}

}  // namespace freeplay::python
