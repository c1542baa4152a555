#include "study/calibrate.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <boost/math/distributions/normal.hpp>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>

#include "facade/simulation.hpp"
#include "measure/measurement.hpp"
#include "model/scene.hpp"
#include "study/data_units.hpp"
#include "study/ideal_turn.hpp"
#include "study/intervals.hpp"

namespace freeplay {
namespace {

TurnMetrics::Name metric_of(const std::string& name) {
  const auto& names = TurnMetrics::names();
  return static_cast<TurnMetrics::Name>(std::ranges::find(names, name) - names.begin());
}

/// Targets that share a scene, and how it is sampled, share its runs.
std::string name_of_run(const std::string& what, const Target& target) {
  return fmt::format("{} {}{}", what, fmt::join(target.overrides, " "),
                     target.sampling > 0 ? fmt::format(" {} Hz", target.sampling) : "");
}

/// The study's scene at ξ for one target.
Variant variant_at(const Study& study, const std::string& what, const Eigen::VectorXd& xi,
                   const Target& target, int starts, double revolutions) {
  const auto& c = *study.calibration;
  const auto name = name_of_run(what, target);
  Variant v{name, name, study.scene, target.overrides, {c.formulation}, starts, revolutions, target.sampling};
  for (std::size_t j = 0; j < c.unknowns.size(); ++j)
    v.overrides.push_back(
        fmt::format("{}={}", c.unknowns[j].key, unscaled(c.unknowns[j], xi[static_cast<Eigen::Index>(j)])));
  return v;
}

/// The runs' own values of a statistic.
std::vector<double> outcomes_of(const std::vector<RunRow>& rows, const std::string& variant,
                                TurnMetrics::Name name) {
  std::vector<double> list;
  for (const auto& r : rows)
    if (r.variant == variant) list.push_back(r.metric[name]);
  return list;
}

bool all_positive(const std::vector<double>& list) {
  return std::ranges::all_of(list, [](double x) { return x > 0; });
}

Estimate possible(const Interval& s, TurnMetrics::Kind kind) {
  const auto in = within_range(s, kind);
  return {in.mean, in.low, in.high};
}

/// A share is no more than all.
Estimate possible(Estimate e, TurnMetrics::Kind kind) {
  if (kind == TurnMetrics::Kind::share)
    for (double* x : {&e.value, &e.low, &e.high}) *x = std::min(*x, 1.0);
  return e;
}

/// The statistic of a measured file, by the same rules as a run's, which take its sampling; and what to ask about its
/// units.
double measured_statistic(const Study& study, Target& target, const Conduct& conduct,
                          std::vector<std::string>& questions) {
  Case one{"", study.calibration->formulation, {}, 0, 1, study.scene, target.overrides};
  const auto scene = scene_of(study, one, conduct);
  const double speed = main_drive(scene.mechanism)->speed;
  const auto ideal = ideal_turn(study, scene, study.calibration->formulation, conduct);
  const auto data = read_measurement(target.data, speed, ideal.value[TurnMetrics::peak_max]);
  target.sampling = data.sampling;
  TurnRules rules;
  rules.speed = speed;
  rules.joint = -1;
  rules.line_share = study.line_share;
  rules.ideal_maximum = ideal.value[TurnMetrics::peak_max];
  TurnMeter meter(rules);
  for (std::size_t i = 0; i < data.acceleration.size(); ++i)
    meter.acceleration(data.time[i], data.acceleration[i]);
  const auto measured = meter.finish(data.time.back(), std::nan(""));
  if (const auto question = unit_question(measured, ideal); !question.empty())
    questions.push_back(fmt::format("{}: {}", target.data.string(), question));
  const double value = measured.value[metric_of(target.statistic)];
  if (!(value > 0))
    throw SceneError(
        fmt::format("{}: gives no {} (a signal alone has no contacts, and a logarithm is fitted)",
                    target.data.string(), target.statistic));
  return value;
}

}  // namespace

Estimate one_more(std::vector<double> outcomes) {
  std::erase_if(outcomes, [](double x) { return !std::isfinite(x); });
  std::ranges::sort(outcomes);
  std::vector<double> logarithms;
  for (double x : outcomes)
    if (x > 0) logarithms.push_back(std::log(x));
  const auto s = interval(logarithms);  // mean ± t √(s²/n)
  const double half = (s.high - s.mean) * std::sqrt(s.count + 1.0);
  if (logarithms.size() == outcomes.size())
    return {std::exp(s.mean), std::exp(s.mean - half), std::exp(s.mean + half)};
  return {quantile(outcomes, 0.5), 0, logarithms.size() < 2 ? outcomes.back() : std::exp(s.mean + half)};
}

bool contradicts(const std::vector<double>& outcomes, double measured, double tolerance,
                 double surface_error) {
  if (outcomes.empty() || !all_positive(outcomes)) return true;
  const auto n = static_cast<double>(outcomes.size());
  double mean = 0, squares = 0;
  for (double x : outcomes) mean += std::log(x) / n;
  for (double x : outcomes) squares += std::pow(std::log(x) - mean, 2);
  const double normal = boost::math::quantile(boost::math::normal(), 0.995);
  const double one = n > 1 ? boost::math::quantile(boost::math::students_t(n - 1), 0.995) *
                                 std::sqrt((1 + 1 / n) * squares / (n - 1))
                           : normal * surface_error;
  return std::abs(std::log(measured) - mean) > std::hypot(normal * tolerance, one);
}

CalibrationPlan plan_calibration(const Study& study, const Conduct& conduct) {
  if (!study.calibration) throw SceneError(fmt::format("{}: has no [calibrate]", study.file.string()));
  const auto& c = *study.calibration;
  const auto n = static_cast<int>(c.unknowns.size());
  if (c.points < ResponseSurface::coefficients(n) + 2)
    throw SceneError(fmt::format("{}: calibrate.points must be at least {} for {} unknowns, is {}",
                                 study.file.string(), ResponseSurface::coefficients(n) + 2, n, c.points));
  CalibrationPlan p{study, c.targets, {}, {}, space_filling(n, c.points), {}};
  for (auto& target : p.targets) {
    const double value =
        target.data.empty() ? target.value : measured_statistic(study, target, conduct, p.questions);
    if (!(value > 0))
      throw SceneError(
          fmt::format("{}: calibrate.targets.{}.value must be greater than 0: its logarithm is fitted",
                      study.file.string(), target.name));
    p.measured.push_back(value);
  }
  // The space-filling set, run like any study.
  p.study.axes.clear();
  p.study.variants.clear();
  for (int k = 0; k < c.points; ++k)
    for (const auto& target : p.targets)
      p.study.variants.push_back(variant_at(study, fmt::format("point {:03}", k), p.points.row(k).transpose(),
                                            target, c.starts, c.revolutions));
  p.runs = plan(p.study, conduct);
  return p;
}

CalibrationResult calibrate(CalibrationPlan planned, const Conduct& conduct, const FolderLock& lock,
                            int threads, const std::function<void(const SweepProgress&)>& on_progress) {
  auto& study = planned.study;
  auto c = *study.calibration;
  c.targets = planned.targets;
  const auto& points = planned.points;
  const auto n = static_cast<int>(c.unknowns.size());
  CalibrationResult result;
  result.measured = planned.measured;
  result.questions = planned.questions;
  Results results(lock.folder() / "calibrate.db", study, conduct.stop);
  result.sweep = sweep(study, planned.runs, conduct, results, lock, threads, on_progress);
  if (result.sweep.interrupted) return result;

  std::vector<ResponseSurface> surfaces;
  std::vector<double> logs, tolerances;
  auto rows = results.runs(result.sweep.keys);
  for (std::size_t i = 0; i < c.targets.size(); ++i) {
    const auto& target = c.targets[i];
    std::vector<int> usable, without;
    std::vector<double> outcomes;
    for (int p = 0; p < c.points; ++p) {
      const auto of =
          outcomes_of(rows, name_of_run(fmt::format("point {:03}", p), target), metric_of(target.statistic));
      if (of.empty()) continue;  // its runs failed
      const double mean = interval(of).mean;
      if (!(mean > 0) || std::ranges::any_of(of, [](double x) { return std::isnan(x); })) {
        without.push_back(p);
        continue;
      }
      usable.push_back(p);
      outcomes.push_back(std::log(mean));
    }
    if (!without.empty()) {
      std::string where;
      for (int j = 0; j < n; ++j)
        where += fmt::format("{}{} = {:.4g}", j > 0 ? ", " : "", c.unknowns[j].key,
                             unscaled(c.unknowns[j], points(without[0], j)));
      throw SceneError(fmt::format(
          "{}: calibrate.targets.{}: at {} of {} points (first: {}) runs give no positive {}, whose logarithm is "
          "fitted, and without them the fit would be of the others alone; narrow the ranges of the unknowns to "
          "where it is positive, or take another statistic",
          study.file.string(), target.name, without.size(), c.points, where, target.statistic));
    }
    if (static_cast<int>(usable.size()) < ResponseSurface::coefficients(n) + 2)
      throw std::runtime_error(
          fmt::format("calibration: the runs of {} of {} points failed for {}; {} are needed",
                      c.points - static_cast<int>(usable.size()), c.points, target.name,
                      ResponseSurface::coefficients(n) + 2));
    result.points.push_back(static_cast<int>(usable.size()));
    Eigen::MatrixXd at(usable.size(), n);
    for (std::size_t k = 0; k < usable.size(); ++k)
      at.row(static_cast<Eigen::Index>(k)) = points.row(usable[k]);
    surfaces.emplace_back(
        at, Eigen::Map<Eigen::VectorXd>(outcomes.data(), static_cast<Eigen::Index>(outcomes.size())));
    result.surface_error.push_back(surfaces.back().error());
    result.surface_spread.push_back(surfaces.back().spread());
    logs.push_back(std::log(result.measured[i]));
    tolerances.push_back(c.targets[i].tolerance);
  }
  std::vector<bool> used(c.targets.size(), true);
  result.all = fit(surfaces, logs, tolerances, used, c.unknowns);
  if (c.targets.size() > 1)
    for (std::size_t i = 0; i < c.targets.size(); ++i) {
      used[i] = false;
      result.left_out.push_back(fit(surfaces, logs, tolerances, used, c.unknowns));
      used[i] = true;
    }

  // Every optimum again, by as many and as long runs as the study's own, and every draw by one run.
  std::vector<std::pair<Fit*, std::string>> fits = {{&result.all, "all"}};
  for (std::size_t i = 0; i < result.left_out.size(); ++i)
    fits.emplace_back(&result.left_out[i], "without " + c.targets[i].name);
  const auto draw_name = [](const std::string& fit, int k) { return fmt::format("{} draw {:02}", fit, k); };
  study.variants.clear();
  for (const auto& [f, name] : fits)
    for (const auto& target : c.targets) {
      study.variants.push_back(variant_at(study, name, f->xi, target, study.starts, study.revolutions));
      for (int k = 0; k < draws; ++k)
        study.variants.push_back(
            variant_at(study, draw_name(name, k), f->draws.row(k).transpose(), target, 1, study.revolutions));
    }
  const auto again = sweep(study, plan(study, conduct), conduct, results, lock, threads, on_progress,
                           WorkList::Earlier::named);
  result.sweep.interrupted = again.interrupted;
  result.sweep.ran += again.ran;
  result.sweep.failed += again.failed;
  result.sweep.wall_seconds += again.wall_seconds;
  if (again.interrupted) return result;
  rows = results.runs(again.keys);
  for (const auto& [f, name] : fits)
    for (const auto& target : c.targets) {
      const auto metric = metric_of(target.statistic);
      const auto kind = TurnMetrics::kind(metric);
      const auto i = f->run_again.size();
      const auto own = outcomes_of(rows, name_of_run(name, target), metric);
      f->on_surface[i] = possible(f->on_surface[i], kind);
      f->run_again.push_back(possible(interval(own), kind));
      f->contradicted.push_back(
          f->used[i] && contradicts(own, result.measured[i], target.tolerance, result.surface_error[i]));
      std::vector<double> outcomes;
      for (int k = 0; k < draws; ++k)
        for (double x : outcomes_of(rows, name_of_run(draw_name(name, k), target), metric))
          outcomes.push_back(x);
      f->predictive.push_back(possible(one_more(outcomes), kind));
    }
  return result;
}

}  // namespace freeplay
