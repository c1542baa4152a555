#include "study/calibration/calibrate.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <boost/math/distributions/normal.hpp>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <numbers>
#include <optional>

#include "facade/simulation.hpp"
#include "measure/measurement.hpp"
#include "mechanism/scene.hpp"
#include "study/calibration/data_units.hpp"
#include "study/runs/ideal_turn.hpp"
#include "study/sweep/intervals.hpp"

namespace freeplay {
namespace {

/// A statistic of a run: one of TurnMetrics, or a measure of the study.
struct Statistic {
  TurnMetrics::Name metric = TurnMetrics::count;  ///< count: none
  std::size_t measure = 0;
  double of(const RunRow& row) const {
    return metric == TurnMetrics::count ? row.measures.at(measure) : row.metric.at(metric);
  }
  /// A measure whose logarithm is fitted is positive.
  TurnMetrics::Kind kind() const {
    return metric == TurnMetrics::count ? TurnMetrics::Kind::positive : TurnMetrics::kind(metric);
  }
};

Statistic statistic_of(const Study& study, const Target& target) {
  const auto& names = TurnMetrics::names();
  const auto measure = std::ranges::find(study.measures, target.statistic, &Measure::name);
  if (measure != study.measures.end())
    return {TurnMetrics::count, static_cast<std::size_t>(measure - study.measures.begin())};
  return {static_cast<TurnMetrics::Name>(std::ranges::find(names, target.statistic) - names.begin())};
}

/// Name of the runs of a target. Targets with the same scene and sampling share their runs.
std::string name_of_run(const std::string& what, const Target& target) {
  std::string name = fmt::format("{} {}", what, fmt::join(target.overrides, " "));
  if (target.sampling > 0) name += fmt::format(" {} Hz {} turns", target.sampling, target.turns);
  if (target.noise > 0) name += fmt::format(" +- {} m/s2", target.noise);
  return name;
}

/// The study's scene at ξ for one target. A run has as many turns as each segment of a measured
/// file, because the greatest value of many turns exceeds that of few.
Variant variant_at(const Study& study, const std::string& what, const Eigen::VectorXd& xi,
                   const Target& target, int starts, double revolutions) {
  const auto& c = *study.calibration;
  const auto name = name_of_run(what, target);
  Variant v{name,
            name,
            study.scene,
            target.overrides,
            {c.formulation},
            starts,
            target.turns > 0 ? target.turns : revolutions,
            target.sampling,
            target.noise};
  for (std::size_t j = 0; j < c.unknowns.size(); ++j)
    v.overrides.push_back(
        fmt::format("{}={}", c.unknowns[j].key, unscaled(c.unknowns[j], xi[static_cast<Eigen::Index>(j)])));
  return v;
}

/// Values of a statistic, one for each run.
std::vector<double> outcomes_of(const std::vector<RunRow>& rows, const std::string& variant,
                                const Statistic& statistic) {
  std::vector<double> list;
  for (const auto& r : rows)
    if (r.variant == variant) list.push_back(statistic.of(r));
  return list;
}

bool all_positive(const std::vector<double>& list) {
  return std::ranges::all_of(list, [](double x) { return x > 0; });
}

Estimate possible(const Interval& s, TurnMetrics::Kind kind) {
  const auto in = within_range(s, kind);
  return {in.mean, in.low, in.high};
}

/// Limits a share to 1.
Estimate possible(Estimate e, TurnMetrics::Kind kind) {
  if (kind == TurnMetrics::Kind::share)
    for (double* x : {&e.value, &e.low, &e.high}) *x = std::min(*x, 1.0);
  return e;
}

/// Statistic of a measured file, computed like that of a run, with the sampling rate of the file;
/// and questions about its units.
double measured_statistic(const Study& study, Target& target, const Conduct& conduct,
                          std::vector<std::string>& plausibility_checks) {
  Case one{"", study.calibration->formulation, {}, 0, 1, study.scene, target.overrides};
  const auto scene = scene_of(study, one, conduct);
  const double speed = main_drive(scene.mechanism)->speed;
  const auto ideal = ideal_turn(study, scene, study.calibration->formulation, conduct);
  const auto data =
      read_measurement(target.data, speed, ideal.value[TurnMetrics::peak_max], study.accelerometer);
  target.sampling = data.sampling;
  target.noise = data.uncertainty;
  TurnRules rules;
  rules.speed = speed;
  rules.joint = -1;
  rules.line_share = study.line_share;
  rules.ideal_maximum = ideal.value[TurnMetrics::peak_max];
  const auto between = [&](double from, double to) {
    TurnMeter meter(rules);
    for (std::size_t i = 0; i < data.acceleration.size(); ++i)
      if (data.time[i] >= from && data.time[i] < to) meter.acceleration(data.time[i], data.acceleration[i]);
    return meter.finish(data.time.back(), std::nan(""));
  };
  const auto measured = between(-INFINITY, INFINITY);
  if (const auto plausibility = unit_plausibility(measured, ideal); !plausibility.empty())
    plausibility_checks.push_back(fmt::format("{}: {}", target.data.string(), plausibility));
  // Evaluate segments as long as a run: their mean has the expectation of the runs, even for a
  // statistic that depends on the number of turns.
  const auto whole = static_cast<int>(measured.peaks.size());
  target.turns = std::clamp(static_cast<int>(study.calibration->revolutions), 1, std::max(whole, 1));
  target.stretches.count = std::max(1, whole / target.turns);
  const double stretch = target.turns * 2 * std::numbers::pi / std::abs(speed);
  // With rounded times, a sample at the end of a segment belongs to the next one.
  const double half = 0.5 / data.sampling;
  double value = 0, squares = 0;
  std::vector<double> of;
  for (int k = 0; k < target.stretches.count; ++k) {
    const double from = data.time.front() + k * stretch - half;
    of.push_back(between(from, target.stretches.count > 1 ? from + stretch : INFINITY)
                     .value[statistic_of(study, target).metric]);
    value += of.back() / target.stretches.count;
  }
  if (!(value > 0))
    throw SceneError(fmt::format("{}: has no {} (a signal has no contacts, and a logarithm is fitted)",
                                 target.data.string(), target.statistic));
  for (const double x : of) squares += std::pow(x / value - 1, 2);
  if (of.size() > 1) target.stretches.spread = squares / static_cast<double>(of.size() - 1);
  return value;
}

/// Runs that several targets share, and their outcomes at each ξ: a row for each start, a column
/// for each target.
struct Runs {
  std::vector<std::size_t> targets;
  std::vector<Eigen::VectorXd> xi;
  std::vector<Eigen::MatrixXd> outcomes;
};

/// All outcomes so far, and the misfit that follows from them.
class Evidence {
 public:
  Evidence(const Study& study, const Calibration& c, const std::vector<double>& measured)
      : study_(study), c_(c), measured_(measured) {
    for (std::size_t i = 0; i < c.targets.size(); ++i) {
      const auto& target = c.targets[i];
      const auto same = std::ranges::find_if(runs_, [&](const Runs& r) {
        return name_of_run("", c.targets[r.targets.front()]) == name_of_run("", target);
      });
      if (same == runs_.end())
        runs_.push_back({{i}, {}, {}});
      else
        same->targets.push_back(i);
      statistics_.push_back(statistic_of(study, target));
    }
  }

  const Statistic& statistic(std::size_t target) const { return statistics_[target]; }

  void add(const std::vector<RunRow>& rows, const std::string& point, const Eigen::VectorXd& xi) {
    ++tried_;
    for (auto& r : runs_) {
      std::vector<const RunRow*> own;
      const auto name = name_of_run(point, c_.targets[r.targets.front()]);
      for (const auto& row : rows)
        if (row.variant == name) own.push_back(&row);
      if (own.empty()) continue;  // its runs failed
      Eigen::MatrixXd outcomes(own.size(), r.targets.size());
      for (Eigen::Index s = 0; s < outcomes.rows(); ++s)
        for (Eigen::Index k = 0; k < outcomes.cols(); ++k)
          outcomes(s, k) =
              statistics_[r.targets[static_cast<std::size_t>(k)]].of(*own[static_cast<std::size_t>(s)]);
      r.xi.push_back(xi);
      r.outcomes.push_back(outcomes);
    }
  }
  int tried() const { return tried_; }
  std::vector<CalibrationResult::Outcome> outcomes() const {
    std::vector<CalibrationResult::Outcome> all;
    for (const auto& r : runs_)
      for (std::size_t k = 0; k < r.targets.size(); ++k)
        for (std::size_t p = 0; p < r.xi.size(); ++p)
          all.push_back({r.targets[k], r.xi[p], r.outcomes[p].col(static_cast<Eigen::Index>(k)).mean()});
    return all;
  }

  /// Throws SceneError if a statistic is not positive at some point.
  Misfit misfit(CalibrationResult& result) const {
    std::vector<std::optional<Observed>> observed(c_.targets.size());
    std::vector<Scatter> scatter;
    result.points.assign(c_.targets.size(), 0);
    result.surface_error.assign(c_.targets.size(), 0);
    result.surface_spread.assign(c_.targets.size(), 0);
    for (std::size_t g = 0; g < runs_.size(); ++g) {
      const auto& r = runs_[g];
      for (std::size_t k = 0; k < r.targets.size(); ++k) require_positive(r, k);
      scatter.emplace_back();
      for (std::size_t p = 0; p < r.xi.size(); ++p) scatter.back().add(r.xi[p], r.outcomes[p]);
      scatter.back().choose_widths();
      for (std::size_t k = 0; k < r.targets.size(); ++k) {
        const auto i = r.targets[k];
        const auto& target = c_.targets[i];
        const auto source = std::ranges::find(c_.targets, target.data, &Target::data) - c_.targets.begin();
        observed[i] = Observed{surface(r, k, scatter.back(), target),
                               std::log(measured_[i]),
                               target.tolerance,
                               target.stretches,
                               static_cast<int>(g),
                               static_cast<int>(k),
                               static_cast<int>(source)};
        result.points[i] = static_cast<int>(r.xi.size());
        result.surface_error[i] = observed[i]->surface.error();
        result.surface_spread[i] = observed[i]->surface.spread();
      }
    }
    std::vector<Observed> list;
    for (auto& o : observed) list.push_back(std::move(*o));
    return {std::move(list), std::move(scatter)};
  }

 private:
  void require_positive(const Runs& r, std::size_t column) const {
    const auto& target = c_.targets[r.targets[column]];
    std::vector<std::size_t> without;
    for (std::size_t p = 0; p < r.xi.size(); ++p)
      if (!(r.outcomes[p].col(static_cast<Eigen::Index>(column)).mean() > 0)) without.push_back(p);
    if (without.empty()) return;
    std::string where;
    for (std::size_t j = 0; j < c_.unknowns.size(); ++j)
      where += fmt::format("{}{} = {:.4g}", j > 0 ? ", " : "", c_.unknowns[j].key,
                           unscaled(c_.unknowns[j], r.xi[without[0]][static_cast<Eigen::Index>(j)]));
    throw SceneError(fmt::format(
        "{}: calibrate.targets.{}: at {} of {} points (first: {}) {} is not positive, but its logarithm is "
        "fitted; narrow the unknowns' ranges or use another statistic",
        study_.file.string(), target.name, without.size(), r.xi.size(), where, target.statistic));
  }
  ResponseSurface surface(const Runs& r, std::size_t column, const Scatter& scatter,
                          const Target& target) const {
    const auto n = static_cast<int>(c_.unknowns.size());
    const auto count = static_cast<Eigen::Index>(r.xi.size());
    if (count < ResponseSurface::coefficients(n) + 2)
      throw std::runtime_error(
          fmt::format("calibration: the runs at {} of {} points failed for {}; {} points are needed",
                      tried_ - count, tried_, target.name, ResponseSurface::coefficients(n) + 2));
    Eigen::MatrixXd at(count, n);
    Eigen::VectorXd y(count), noise = Eigen::VectorXd::Ones(count);
    for (Eigen::Index p = 0; p < count; ++p) {
      const auto& outcomes = r.outcomes[static_cast<std::size_t>(p)];
      const auto& xi = r.xi[static_cast<std::size_t>(p)];
      const auto k = static_cast<Eigen::Index>(column);
      at.row(p) = xi.transpose();
      y[p] = std::log(outcomes.col(k).mean());
      if (scatter.known()) noise[p] = scatter.at(xi).covariance(k, k);
      noise[p] /= static_cast<double>(outcomes.rows());
    }
    // Relative; equal where nothing scatters.
    const double mean = noise.mean();
    noise = mean > 0 ? Eigen::VectorXd((noise / mean).cwiseMax(1e-3)) : Eigen::VectorXd::Ones(count);
    return {at, y, noise, scatter.known() ? mean : 0};
  }

  const Study& study_;
  const Calibration& c_;
  const std::vector<double>& measured_;
  std::vector<Runs> runs_;
  std::vector<Statistic> statistics_;
  int tried_ = 0;
};

/// Points for a refinement, from a sample of twice the fit's uncertainty: the optimum, then each
/// time the point that is farthest from those chosen, in units of the sample's spread.
Eigen::MatrixXd where_to_refine(const Misfit& misfit, const Fit& fit, int count) {
  const auto points = sample(misfit, fit, 200, 2);
  const Eigen::VectorXd scale =
      (points.rowwise() - points.colwise().mean()).colwise().norm().cwiseMax(1e-6).cwiseInverse().transpose();
  Eigen::MatrixXd chosen(count, points.cols());
  chosen.row(0) = fit.xi.transpose();
  Eigen::VectorXd nearest = Eigen::VectorXd::Constant(points.rows(), INFINITY);
  for (int k = 1; k < count; ++k) {
    for (Eigen::Index i = 0; i < points.rows(); ++i)
      nearest[i] =
          std::min(nearest[i], ((points.row(i) - chosen.row(k - 1)).transpose().cwiseProduct(scale)).norm());
    Eigen::Index farthest = 0;
    nearest.maxCoeff(&farthest);
    chosen.row(k) = points.row(farthest);
  }
  return chosen;
}

/// Whether the error of each surface near the optimum is at most half of the measurement's
/// uncertainty.
bool fine_enough(const Misfit& misfit, const Fit& fit) {
  const auto points = sample(misfit, fit, 20);
  for (std::size_t i = 0; i < misfit.targets().size(); ++i) {
    double surface = 0, known = 0;
    for (Eigen::Index p = 0; p < points.rows(); ++p) {
      const auto parts = misfit.parts(i, points.row(p).transpose());
      surface += parts.surface;
      known += parts.scatter + std::pow(misfit.targets()[i].tolerance, 2);
    }
    if (surface > 0.25 * known) return false;
  }
  return true;
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

bool contradicts(const std::vector<double>& outcomes, double measured, double tolerance, double surface_error,
                 const Stretches& stretches) {
  if (outcomes.empty() || !all_positive(outcomes)) return true;
  const auto n = static_cast<double>(outcomes.size());
  double mean = 0, squares = 0;
  for (double x : outcomes) mean += std::log(x) / n;
  for (double x : outcomes) squares += std::pow(std::log(x) - mean, 2);
  const double normal = boost::math::quantile(boost::math::normal(), 0.995);
  const double one = n > 1 ? boost::math::quantile(boost::math::students_t(n - 1), 0.995) *
                                 std::sqrt((stretches.share(squares / (n - 1)) + 1 / n) * squares / (n - 1))
                           : normal * surface_error;
  // For a single start, `one` contains it.
  const double surface = n > 1 ? normal * surface_error : 0;
  return std::abs(std::log(measured) - mean) > std::hypot(normal * tolerance, one, surface);
}

CalibrationPlan plan_calibration(const Study& study, const Conduct& conduct) {
  if (!study.calibration) throw SceneError(fmt::format("{}: has no [calibrate]", study.file.string()));
  const auto& c = *study.calibration;
  if (c.targets.front().is_quantity())
    throw SceneError(fmt::format(
        "{}: calibrate.targets.{}: \"{}\" is a quantity of one run; only `freeplay calibrate` on one machine "
        "fits those",
        study.file.string(), c.targets.front().name, c.targets.front().statistic));
  const auto n = static_cast<int>(c.unknowns.size());
  if (c.points < ResponseSurface::coefficients(n) + 2)
    throw SceneError(fmt::format("{}: calibrate.points must be at least {} for {} unknowns, is {}",
                                 study.file.string(), ResponseSurface::coefficients(n) + 2, n, c.points));
  CalibrationPlan p{study, c.targets, {}, {}, space_filling(n, c.points), {}};
  for (auto& target : p.targets) {
    const double value = target.data.empty()
                             ? target.value
                             : measured_statistic(study, target, conduct, p.plausibility_checks);
    if (!(value > 0))
      throw SceneError(
          fmt::format("{}: calibrate.targets.{}.value must be greater than 0: its logarithm is fitted",
                      study.file.string(), target.name));
    p.measured.push_back(value);
  }
  // The space-filling design is run like any study.
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
  result.plausibility_checks = planned.plausibility_checks;
  Results results(lock.folder() / "calibrate.db", study, conduct.stop);
  result.sweep = sweep(study, planned.runs, conduct, results, lock, threads, on_progress);
  if (result.sweep.interrupted) return result;

  // Executes more runs of the same study; false if interrupted.
  std::vector<RunRow> rows;
  const auto run = [&] {
    const auto more = sweep(study, plan(study, conduct), conduct, results, lock, threads, on_progress,
                            WorkList::Earlier::named);
    result.sweep.interrupted = more.interrupted;
    result.sweep.ran += more.ran;
    result.sweep.failed += more.failed;
    result.sweep.in_lanes += more.in_lanes;
    result.sweep.wall_seconds += more.wall_seconds;
    if (!more.interrupted) rows = results.runs(more.keys);
    return !more.interrupted;
  };

  Evidence evidence(study, c, result.measured);
  rows = results.runs(result.sweep.keys);
  for (int p = 0; p < c.points; ++p)
    evidence.add(rows, fmt::format("point {:03}", p), points.row(p).transpose());
  const std::vector<bool> every(c.targets.size(), true);
  auto misfit = evidence.misfit(result);
  result.before = identifiability(misfit, points);
  result.all = fit(misfit, every, c.unknowns);
  while (!(result.refined = fine_enough(misfit, result.all)) && result.rounds < c.refinements) {
    const auto more = where_to_refine(misfit, result.all, 2 * n + 2);
    const auto name = [&](Eigen::Index k) { return fmt::format("refinement {} {:02}", result.rounds, k); };
    study.variants.clear();
    for (Eigen::Index k = 0; k < more.rows(); ++k)
      for (const auto& target : c.targets)
        study.variants.push_back(
            variant_at(study, name(k), more.row(k).transpose(), target, c.starts, c.revolutions));
    if (!run()) return result;
    for (Eigen::Index k = 0; k < more.rows(); ++k) evidence.add(rows, name(k), more.row(k).transpose());
    ++result.rounds;
    misfit = evidence.misfit(result);
    result.all = fit(misfit, every, c.unknowns);
  }
  result.tried = evidence.tried();
  result.outcomes = evidence.outcomes();
  for (std::size_t y = 0; y < c.unknowns.size(); ++y)
    for (std::size_t x = 0; x < y; ++x)
      result.maps.push_back(
          {x, y, misfit_map(misfit, result.all, static_cast<Eigen::Index>(x), static_cast<Eigen::Index>(y))});
  for (std::size_t i = 0; i < c.targets.size(); ++i)
    result.at_optimum.push_back(misfit.parts(i, result.all.xi));
  if (c.targets.size() > 1)
    for (std::size_t i = 0; i < c.targets.size(); ++i) {
      auto used = every;
      used[i] = false;
      result.left_out.push_back(fit(misfit, used, c.unknowns));
    }

  // Repeat each optimum with as many and as long runs as the study's own, and each draw with one
  // run.
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
  if (!run()) return result;
  for (const auto& [f, name] : fits) {
    for (const auto& target : c.targets) {
      const auto i = f->run_again.size();
      const auto& statistic = evidence.statistic(i);
      const auto own = outcomes_of(rows, name_of_run(name, target), statistic);
      f->on_surface[i] = possible(f->on_surface[i], statistic.kind());
      f->run_again.push_back(possible(interval(own), statistic.kind()));
      const double surface_error =
          own.size() > 1 ? std::sqrt(misfit.parts(i, f->xi).surface) : result.surface_error[i];
      f->contradicted.push_back(f->used[i] && contradicts(own, result.measured[i], target.tolerance,
                                                          surface_error, target.stretches));
      std::vector<double> outcomes;
      for (int k = 0; k < draws; ++k)
        for (double x : outcomes_of(rows, name_of_run(draw_name(name, k), target), statistic))
          outcomes.push_back(x);
      f->predictive.push_back(possible(one_more(outcomes), statistic.kind()));
    }
    // An inconsistent fit has no intervals.
    if (!f->holds())
      for (auto& u : f->unknowns) u = {u.value, std::nan(""), std::nan("")};
  }
  return result;
}

}  // namespace freeplay
