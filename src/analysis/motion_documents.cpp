#include "analysis/motion_documents.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <nlohmann/json.hpp>
#include <span>

#include "analysis/orbit.hpp"
#include "analysis/sensitivity.hpp"
#include "dynamics/planar.hpp"
#include "dynamics/system.hpp"
#include "mechanism/scene.hpp"

namespace freeplay {
namespace {

using nlohmann::json;

/// The state by the names of trajectory.csv, which has the bodies in the mechanism's order.
json state_json(const Scene& scene, const State& s) {
  json list = {{"t", s.t}};
  for (std::size_t i = 0; i < s.q.size(); ++i) {
    const auto& body = scene.mechanism.bodies[i / 3].name;
    list[fmt::format("{}.{}", body, planar::names[i % 3])] = s.q[i];
    list[fmt::format("{}.{}", body, planar::rate_names[i % 3])] = s.v[i];
  }
  if (!s.z.empty()) list["first_order_states"] = s.z;
  return list;
}

json multipliers_json(const Orbit& orbit) {
  auto list = json::array();
  for (const auto& m : orbit.multipliers) list.push_back({m.real(), m.imag()});
  return list;
}

std::complex<double> first_multiplier(const Orbit& o) {
  return o.multipliers.empty() ? std::complex<double>(0) : o.multipliers.front();
}

/// Phase of an impact in the period of the drive.
double phase_in(double t, double period) {
  const double phase = t / period - std::floor(t / period);
  return phase < 1 ? phase : 0;
}

json quantity_json(const Sensitivities& all, const Sensitivity& q) {
  json derivatives = json::object(), influences = derivatives, reasons = derivatives, errors = derivatives,
       inexact = json::array();
  std::string first;
  double condition = NAN;
  bool differentiable = true;
  for (std::size_t i = 0; i < all.keys.size(); ++i) {
    const auto& key = all.keys[i];
    derivatives[key] = q.derivatives[i];
    influences[key] = influence(all, q, i);
    errors[key] = q.errors[i];
    if (is_inexact(all, q, i)) inexact.push_back(key);
    differentiable = differentiable && std::isfinite(q.derivatives[i]);
    condition = std::fmax(condition, std::abs(influence(all, q, i)));  // of those that exist
    if (q.reasons[i].empty()) continue;
    reasons[key] = q.reasons[i];
    if (first.empty()) first = q.reasons[i];
  }
  return {{"name", q.name},
          {"value", q.value},
          {"derivatives", derivatives},
          {"error", errors},
          {"inexact", inexact},
          {"relative_influence", influences},
          {"condition", condition},
          {"differentiable", differentiable},
          {"reason", first},
          {"reasons", reasons}};
}

}  // namespace

json to_json(const Scene& scene, const OrbitRequest& request, const Orbit& found) {
  json impacts = json::array(), lasting = impacts;
  for (const auto& i : found.impacts)
    impacts.push_back({{"time", i.t}, {"joint", i.joint}, {"speed", i.speed}});
  for (const auto& c : found.lasting) {
    lasting.push_back({{"joint", c.joint}, {"least_force", c.least_force}, {"time", c.t}});
    if (c.v0) lasting.back()["v0"] = *c.v0;
  }
  json document = {{"period_s", found.period},
                   {"periods", found.periods},
                   {"residual", found.residual},
                   {"state", state_json(scene, found.state)},
                   {"impacts", impacts},
                   {"lasting", lasting},
                   {"multipliers", multipliers_json(found)},
                   {"stable", found.stable},
                   {"iterations", found.iterations},
                   {"formulation", request.formulation},
                   {"settle", request.settle}};
  if (request.period) document["period_given_s"] = *request.period;
  if (!request.shift.empty()) document["shift"] = {{"coordinates", request.shift}, {"change", found.shift}};
  if (found.moved > 0) document["section_moved_s"] = found.moved;
  if (found.step_error > 0) document["step_error"] = found.step_error;
  return document;
}

json to_json(const Lyapunov& found, const std::string& formulation) {
  auto list = json::array();
  for (const auto& e : found.exponents)
    list.push_back({{"per_s", e.value},
                    {"standard_error_per_s", e.error},
                    {"per_period", found.period > 0 ? e.value * found.period : NAN},
                    {"reason", e.reason}});
  return {{"exponents", list},
          {"period_s", found.period > 0 ? found.period : NAN},
          {"sum_per_s", found.sum},
          {"sum_standard_error_per_s", found.sum_error},
          {"sum_predicted_per_s", found.predicted},
          {"divergence_per_s", found.divergence},
          {"impacts_part_per_s", found.impact_part},
          {"not_predicted", found.unpredicted},
          {"impacts", found.impacts},
          {"transient_s", found.transient},
          {"duration_s", found.duration},
          {"batches", found.batches},
          {"cost_over_run", found.cost},
          {"stopped", found.stopped},
          {"formulation", formulation}};
}

Table course_table(const Lyapunov& found) {
  Table table("t");
  for (std::size_t i = 1; i <= found.exponents.size(); ++i) table.column(fmt::format("exponent_{}", i));
  table.column("sum");
  table.column("sum_predicted");
  for (const auto& s : found.course) {
    std::vector<Table::Cell> row{fmt::format("{:.17g}", s.t)};
    const auto field = [&](double x) { row.emplace_back(std::isfinite(x) ? fmt::format("{:.17g}", x) : ""); };
    for (const double x : s.exponents) field(x);
    field(s.sum);
    field(s.predicted);
    table.row(std::move(row));
  }
  return table;
}

double influence(const Sensitivities& all, const Sensitivity& q, std::size_t key) {
  constexpr double rounding_part = 1e-10;  // of the greatest p dQ/dp: below it, a value is zero
  double greatest = 0;
  for (std::size_t i = 0; i < all.keys.size(); ++i)
    if (const double change = std::abs(q.derivatives[i] * all.key_values[i]); std::isfinite(change))
      greatest = std::max(greatest, change);
  return std::abs(q.value) > rounding_part * greatest ? q.derivatives[key] * all.key_values[key] / q.value
                                                      : NAN;
}

json to_json(const Sensitivities& all, const std::vector<double>& deviations,
             const std::string& formulation) {
  auto quantities = json::array(), keys = json::array();
  for (const auto& q : all.quantities) {
    quantities.push_back(quantity_json(all, q));
    if (!deviations.empty()) quantities.back()["standard_deviation"] = propagated_deviation(q, deviations);
  }
  for (std::size_t i = 0; i < all.keys.size(); ++i) {
    keys.push_back({{"name", all.keys[i]}, {"value", all.key_values[i]}});
    if (!deviations.empty()) keys.back()["standard_deviation"] = deviations[i];
  }
  return {{"quantities", quantities},
          {"keys", keys},
          {"cost_over_run", all.cost},
          {"stopped", all.stopped},
          {"formulation", formulation}};
}

const char* name_of(BifurcationKind kind) { return bifurcation_names[static_cast<std::size_t>(kind)]; }

BranchTables::BranchTables(const Scene& scene)
    : branch(
          "branch,point,parameter,period_s,stable,greatest_modulus,multiplier_re,multiplier_im,periods,"
          "impacts,least_speed,least_force,t"),
      impacts("branch,point,parameter,stable,t,phase,joint,approach"),
      bifurcations(
          "kind,parameter,period_s,branch,point,periods,multiplier_re,multiplier_im,joint,follows,"
          "new_branch,residual"),
      curves(
          "curve,kind,parameter,second,period_s,periods,stable,greatest_modulus,multiplier_re,"
          "multiplier_im,joint,residual") {
  for (const auto& parts : {planar::names, planar::rate_names})
    for (const char* part : parts)
      for (const auto& body : scene.mechanism.bodies) branch.column(fmt::format("{}.{}", body.name, part));
  const int states = System(scene.mechanism).states();
  for (int k = 1; k <= states; ++k) branch.column(fmt::format("z{}", k));
}

std::vector<double> BranchTables::values(const BranchPoint& p) {
  const auto& o = p.orbit;
  double slowest = NAN, weakest = NAN;
  for (const auto& i : o.impacts) slowest = std::isnan(slowest) ? i.speed : std::min(slowest, i.speed);
  for (const auto& c : o.lasting)
    weakest = std::isnan(weakest) ? c.least_force : std::min(weakest, c.least_force);
  const auto first = first_multiplier(o);
  std::vector<double> list{static_cast<double>(p.branch),
                           static_cast<double>(p.number),
                           p.parameter,
                           o.period,
                           o.stable ? 1.0 : 0.0,
                           std::abs(first),
                           first.real(),
                           first.imag(),
                           static_cast<double>(o.periods),
                           static_cast<double>(o.impacts.size()),
                           slowest,
                           weakest,
                           o.state.t};
  for (const auto* part_of : {&o.state.q, &o.state.v})
    for (std::size_t part = 0; part < 3; ++part)
      for (std::size_t i = part; i < part_of->size(); i += 3) list.push_back((*part_of)[i]);
  list.insert(list.end(), o.state.z.begin(), o.state.z.end());
  return list;
}

void BranchTables::add(const Branches& found) {
  for (const auto& p : std::span(found.points).subspan(branch.rows().size())) {
    branch.row(values(p));
    for (const auto& i : p.orbit.impacts)
      impacts.row(p.branch, p.number, p.parameter, p.orbit.stable, i.t, phase_in(i.t, p.orbit.period),
                  i.joint, i.speed);
  }
  for (const auto& b : std::span(found.bifurcations).subspan(bifurcations.rows().size())) {
    const auto first = first_multiplier(b.at.orbit);
    bifurcations.row(name_of(b.kind), b.at.parameter, b.at.orbit.period, b.at.branch, b.at.number,
                     b.at.orbit.periods, first.real(), first.imag(), b.joint, b.follows, b.new_branch,
                     b.residual);
  }
  for (const auto& c : std::span(found.curve_points).subspan(curves.rows().size())) {
    const auto first = first_multiplier(c.orbit);
    curves.row(c.curve, name_of(c.kind), c.parameter, c.second, c.orbit.period, c.orbit.periods,
               c.orbit.stable, std::abs(first), first.real(), first.imag(), c.joint, c.residual);
  }
}

json to_json(const std::vector<BranchEnd>& ends) {
  auto list = json::array();
  for (const auto& e : ends)
    list.push_back({{"branch", e.branch}, {"points", e.points}, {"begins", e.begins}, {"ends", e.reason}});
  return list;
}

json to_json(const std::vector<Bifurcation>& bifurcations) {
  auto list = json::array();
  for (const auto& b : bifurcations)
    list.push_back({{"kind", name_of(b.kind)},
                    {"parameter", b.at.parameter},
                    {"period_s", b.at.orbit.period},
                    {"branch", b.at.branch},
                    {"joint", b.joint},
                    {"follows", b.follows},
                    {"new_branch", b.new_branch},
                    {"residual", b.residual},
                    {"multipliers", multipliers_json(b.at.orbit)},
                    {"t", b.at.orbit.state.t},
                    {"q", b.at.orbit.state.q},
                    {"v", b.at.orbit.state.v}});
  return list;
}

json to_json(const std::vector<CurveEnds>& curves) {
  auto list = json::array();
  for (const auto& c : curves)
    list.push_back({{"curve", c.curve},
                    {"kind", name_of(c.kind)},
                    {"points", c.points},
                    {"parameter", c.parameter},
                    {"ends", {c.reasons[0], c.reasons[1]}}});
  return list;
}

}  // namespace freeplay
