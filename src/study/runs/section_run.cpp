#include "study/runs/section_run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "io/scene/read_scene.hpp"
#include "mechanism/duration.hpp"
#include "mechanism/scene.hpp"
#include "values/diagnostic.hpp"

namespace freeplay {
namespace {

SectionPlan plan_of(const Scene& scene, const Layout& layout, const SectionRequest& r) {
  SectionPlan p;
  p.rule = read_section(r.section, scene, layout, r.section_key, r.period);
  p.period = r.period.value_or(p.rule.period);
  if (!(p.period > 0)) p.period = drive_period(scene).value_or(0);
  if (r.columns.empty())
    p.columns = all_columns(scene, layout, p.rule);
  else
    for (const auto& name : r.columns)
      p.columns.push_back(read_column(name, scene, layout, p.rule, r.column_key));
  p.shown = shown_columns(scene, layout, p.rule);
  if ((r.discard || r.keep) && !(p.period > 0))
    throw ModelError(
        r.periods_key,
        "counts periods, but the drives of the scene define none, or several; give it, such as \"every 0.1 "
        "s\"");
  p.discard = r.discard ? *r.discard * p.period : scene.run.discard;
  p.until = r.keep ? (r.discard.value_or(0) + *r.keep) * p.period : scene.run.duration;
  require_duration(r.periods_key, p.discard);
  require_duration(r.periods_key, p.until);
  if (!(p.until > p.discard))
    throw ModelError("run.duration",
                     fmt::format("{} s: is shorter than the {} s that are discarded", p.until, p.discard));
  if (const double count = (p.until - p.discard) / p.rule.period;
      p.rule.kind == SectionRule::Kind::period && count > static_cast<double>(SectionPoints::most))
    throw ModelError(r.section_key,
                     fmt::format("has {:.3g} points, and at most {} are kept: use a longer interval or a "
                                 "shorter run",
                                 count, SectionPoints::most));
  return p;
}

/// The scene without parts that a section does not need.
Scene bare(const Scene& scene) {
  Scene s = scene;
  s.instruments.clear();
  return s;
}

}  // namespace

SectionSimulation::SectionSimulation(const Scene& scene, const SectionRequest& request, StopToken stop,
                                     SharedCompilation* compilation)
    : stop_(stop),
      simulation_(located_in(scene,
                             [&] {
                               auto options = compilation ? compilation->options(scene, request.formulation)
                                                          : SimulationOptions{};
                               options.start = request.start;
                               options.stop = stop;
                               return Simulation(bare(scene), request.formulation, options);
                             })),
      plan_(located_in(scene, [&] { return plan_of(scene, simulation_.layout(), request); })) {}

RunRequest SectionSimulation::request() {
  std::vector<StateColumn> columns;
  for (const auto& c : plan_.columns) columns.push_back(c.column);
  points_ = std::make_unique<SectionPoints>(plan_.rule, columns, plan_.discard);
  return {.until = plan_.until, .observers = {points_.get()}, .keep_events = false, .stop = stop_};
}

std::vector<Observer*> SectionSimulation::followers() const {
  return points_->follows() ? std::vector<Observer*>{points_.get()} : std::vector<Observer*>{};
}

bool SectionSimulation::take(Result result) {
  const auto& points = *points_;
  auto& run = run_;
  run = {.plan = plan_,
         .ending = result.ending,
         .t = {},
         .rows = {},
         .end = simulation_.state(),
         .work = result.work,
         .cpu_seconds = result.cpu_seconds,
         .notes = std::move(result.notes)};
  if (points.lost() > 0) run.notes.push_back(diagnostic<Diagnostic::section_undecided>(points.lost()));
  if (points.beyond() > 0)
    run.notes.push_back(diagnostic<Diagnostic::section_cut>(points.beyond(), SectionPoints::most));
  for (std::size_t i = 0; i < points.size(); ++i) {
    run.t.push_back(points.t(i));
    run.rows.insert(run.rows.end(), points.row(i).begin(), points.row(i).end());
  }
  return false;
}

SectionRun SectionSimulation::run() {
  run_alone(*this);
  return std::move(run_);
}

nlohmann::json to_json(const SectionRun& run, const SectionRequest& request,
                       const std::array<std::string, 2>& shown) {
  const auto column = [&](std::size_t i) -> const NamedColumn& {
    const auto& list = run.plan.columns;
    const auto at =
        std::ranges::find(list, shown[i].empty() ? run.plan.shown[i] : shown[i], &NamedColumn::name);
    return at == list.end() ? list.front() : *at;
  };
  const auto &x = column(0), &y = column(1);
  return {{"section",
           {{"asked", request.section},
            {"formulation", request.formulation},
            {"points", run.size()},
            {"period_s", run.plan.period},
            {"from_s", run.plan.discard},
            {"to_s", run.plan.until},
            {"x", x.name},
            {"x_unit", x.unit},
            {"y", y.name},
            {"y_unit", y.unit},
            {"ending", run.ending.reason},
            {"notes", run.notes}}}};
}

Table section_table(const SectionRun& run) {
  Table points("t");
  for (const auto& c : run.plan.columns) points.column(c.name);
  for (std::size_t i = 0; i < run.size(); ++i) {
    std::vector<double> row{run.t[i]};
    for (std::size_t c = 0; c < run.plan.columns.size(); ++c) row.push_back(run.at(i, c));
    points.row(row);
  }
  return points;
}

}  // namespace freeplay
