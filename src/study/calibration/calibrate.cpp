#include "study/calibration/calibrate.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <boost/math/distributions/binomial.hpp>
#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/normal.hpp>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <numbers>
#include <optional>

#include "facade/simulation.hpp"
#include "measure/measurement.hpp"
#include "measure/waveform.hpp"
#include "mechanism/scene.hpp"
#include "study/calibration/agreement.hpp"
#include "study/runs/turns.hpp"
#include "study/store/results.hpp"

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
  const auto measure = std::ranges::find(study.measures, target.measure(), &Measure::name);
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
  if (target.is_waveform()) {
    const auto expected = expected_difference(turns_of(data, speed), target.turns, target.tolerance);
    if (!(expected.value > 0))
      throw SceneError(fmt::format("{}: a waveform needs at least two revolutions", target.data.string()));
    target.tolerance = expected.deviation;
    target.stretches.known = true;
    return expected.value;
  }
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
  std::vector<int> point;  // numbers of the points whose runs finished
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
        runs_.push_back({{i}, {}, {}, {}});
      else
        same->targets.push_back(i);
      statistics_.push_back(statistic_of(study, target));
    }
  }

  const Statistic& statistic(std::size_t target) const { return statistics_[target]; }

  void add(const std::vector<RunRow>& rows, const std::string& point, const Eigen::VectorXd& xi) {
    tried_.push_back(xi);
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
      r.point.push_back(static_cast<int>(tried_.size()) - 1);
      r.xi.push_back(xi);
      r.outcomes.push_back(outcomes);
    }
  }
  int tried() const { return static_cast<int>(tried_.size()); }
  /// All points, one a row.
  Eigen::MatrixXd points() const {
    Eigen::MatrixXd all(tried_.size(), tried_.front().size());
    for (std::size_t p = 0; p < tried_.size(); ++p)
      all.row(static_cast<Eigen::Index>(p)) = tried_[p].transpose();
    return all;
  }
  /// Outcomes at one point; none if a run failed or a statistic is not positive there.
  std::optional<Misfit::Own> own(int point) const {
    const auto m = static_cast<Eigen::Index>(c_.targets.size());
    Misfit::Own all{Eigen::VectorXd(m), Eigen::VectorXd(m)};
    for (const auto& r : runs_) {
      const auto at = std::ranges::lower_bound(r.point, point);
      if (at == r.point.end() || *at != point) return {};
      const auto& outcomes = r.outcomes[static_cast<std::size_t>(at - r.point.begin())];
      for (std::size_t k = 0; k < r.targets.size(); ++k) {
        const double mean = outcomes.col(static_cast<Eigen::Index>(k)).mean();
        if (!(mean > 0)) return {};
        all.logarithms[static_cast<Eigen::Index>(r.targets[k])] = std::log(mean);
        all.starts[static_cast<Eigen::Index>(r.targets[k])] = static_cast<double>(outcomes.rows());
      }
    }
    return all;
  }
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
                      tried() - count, tried(), target.name, ResponseSurface::coefficients(n) + 2));
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
    return {at, y, noise, scatter.known() ? mean : -1};
  }

  const Study& study_;
  const Calibration& c_;
  const std::vector<double>& measured_;
  std::vector<Runs> runs_;
  std::vector<Statistic> statistics_;
  std::vector<Eigen::VectorXd> tried_;
};

/// Greatest s_i² over the variance of the measurement, of all targets.
double doubt(const Misfit& misfit, const Eigen::VectorXd& xi) {
  double most = 0;
  for (std::size_t i = 0; i < misfit.targets().size(); ++i) {
    const auto parts = misfit.parts(i, xi);
    most = std::max(most, parts.surface / (parts.scatter + std::pow(misfit.targets()[i].tolerance, 2)));
  }
  return most;
}

/// Points for a refinement: the optimum, then each time the place with the greatest doubt, weighted by
/// exp(−(f − min f)/8) and by its distance from those chosen.
Eigen::MatrixXd where_to_refine(const Misfit& misfit, const Search& now, int count) {
  std::vector<Eigen::VectorXd> chosen{now.best.xi};
  std::vector<double> score;
  std::vector<const Place*> places;
  for (const auto& place : now.places)
    if (place.value < now.best.value + 16 && places.size() < 400) {
      places.push_back(&place);
      score.push_back(std::min(4.0, doubt(misfit, place.xi)) * std::exp(-(place.value - now.best.value) / 8));
    }
  constexpr double apart = 0.1;  // of ξ
  while (static_cast<int>(chosen.size()) < count) {
    double most = 0;
    const Place* next = nullptr;
    for (std::size_t k = 0; k < places.size(); ++k) {
      const double near = (places[k]->xi - chosen.back()).squaredNorm() / (apart * apart);
      score[k] *= 1 - std::exp(-0.5 * near);
      if (score[k] > most) most = score[k], next = places[k];
    }
    if (!next) break;
    chosen.push_back(next->xi);
  }
  Eigen::MatrixXd points(chosen.size(), now.best.xi.size());
  for (std::size_t k = 0; k < chosen.size(); ++k)
    points.row(static_cast<Eigen::Index>(k)) = chosen[k].transpose();
  return points;
}

/// Whether the error of each surface is at most half of the measurement's uncertainty at the optimum and at
/// most places where f is within 4 of its minimum. At the others it is in V, so that they are not excluded.
/// `rough`: the error includes the roughness of the outcomes, which more runs need not reduce.
bool fine_enough(const Misfit& misfit, const Search& now, bool rough = true) {
  for (const auto& target : misfit.targets()) {
    const auto i = static_cast<std::size_t>(&target - misfit.targets().data());
    const auto fine_at = [&](const Eigen::VectorXd& xi) {
      const auto parts = misfit.parts(i, xi);
      return (rough ? parts.surface : target.surface.reducible(xi)) <=
             0.25 * (parts.scatter + target.tolerance * target.tolerance);
    };
    if (!fine_at(now.best.xi)) return false;
    int fine = 0, all = 0;
    for (const auto& place : now.places) {
      if (all == 200 || place.value > now.best.value + 4) break;
      fine += fine_at(place.xi);
      ++all;
    }
    if (2 * fine < all) return false;
  }
  return true;
}

/// Forecasts of the targets at one point for the mean of some starts. An error below half of the
/// measurement's uncertainty does not matter.
std::vector<Forecast> forecasts(const Misfit& misfit, const Eigen::VectorXd& xi, int starts) {
  std::vector<Forecast> list;
  for (std::size_t i = 0; i < misfit.targets().size(); ++i) {
    const auto& target = misfit.targets()[i];
    const auto parts = misfit.parts(i, xi);
    list.push_back({target.surface(xi), parts.surface + parts.run / starts +
                                            0.25 * (parts.scatter + std::pow(target.tolerance, 2))});
  }
  return list;
}

/// Widens the intervals to all points whose own runs meet the targets although the surfaces differ from
/// them by more than their errors.
void widen(Fit& fit, const Misfit& misfit, const Evidence& evidence, const std::vector<Unknown>& unknowns) {
  const auto points = evidence.points();
  for (int p = 0; p < evidence.tried(); ++p) {
    const auto own = evidence.own(p);
    const Eigen::VectorXd xi = points.row(p).transpose();
    if (!own || misfit.at(xi, fit.used, &*own).value > fit.least + fit.level) continue;
    bool differ = false;
    for (std::size_t i = 0; i < misfit.targets().size(); ++i) {
      const auto parts = misfit.parts(i, xi);
      const auto k = static_cast<Eigen::Index>(i);
      const double off = own->logarithms[k] - misfit.targets()[i].surface(xi);
      differ =
          differ || (fit.used[i] && off * off > 2.58 * 2.58 * (parts.run / own->starts[k] + parts.surface));
    }
    for (std::size_t j = 0; differ && j < unknowns.size(); ++j) {
      const double value = unscaled(unknowns[j], xi[static_cast<Eigen::Index>(j)]);
      fit.unknowns[j].low = std::min(fit.unknowns[j].low, value);
      fit.unknowns[j].high = std::max(fit.unknowns[j].high, value);
    }
  }
}

/// Whether the own runs of every point miss the targets at the level of Fit::rejected. If the surfaces do not
/// predict runs, they cannot reject a fit alone.
bool no_run_meets(const Fit& fit, const Misfit& misfit, const Evidence& evidence) {
  const auto points = evidence.points();
  const double most = boost::math::quantile(boost::math::chi_squared(fit.degrees), 0.99);
  for (int p = 0; p < evidence.tried(); ++p)
    if (const auto own = evidence.own(p);
        own && misfit.at(points.row(p).transpose(), fit.used, &*own).squares <= most)
      return false;
  return true;
}

/// Names the statistic that differs most clearly between the ends of a ridge: by the difference of the
/// means over the range of the starts, at least 5 times and by 5 %.
void separate(Ridge& ridge, const Calibration& c, const std::vector<RunRow>& rows, const std::string& low,
              const std::string& high) {
  double clearest = 5;
  for (std::size_t m = 0; m < TurnMetrics::count; ++m) {
    const auto name = TurnMetrics::names()[m];
    if (TurnMetrics::kind(static_cast<TurnMetrics::Name>(m)) != TurnMetrics::Kind::positive ||
        std::ranges::find(c.targets, name, &Target::statistic) != c.targets.end())
      continue;
    std::vector<double> a, b;
    for (const auto& row : rows) {
      if (row.variant == low) a.push_back(std::log(row.metric[m]));
      if (row.variant == high) b.push_back(std::log(row.metric[m]));
    }
    const auto s = interval(a), t = interval(b);
    if (a.size() < 2 || b.size() < 2 || !std::isfinite(s.mean) || !std::isfinite(t.mean)) continue;
    // 1e-3: below the accuracy of any sensor.
    const double deviation = std::max({s.greatest - s.least, t.greatest - t.least, 1e-3});
    const double change = t.mean - s.mean;
    if (std::abs(change) > 0.05 && std::abs(change) / deviation > clearest) {
      clearest = std::abs(change) / deviation;
      ridge.separator = name;
      ridge.change = std::expm1(std::abs(change));
    }
  }
}

}  // namespace

bool predictions_hold(const std::vector<Forecast>& forecasts, const std::vector<double>& outcomes) {
  int count = 0, outside = 0;
  for (std::size_t k = 0; k < outcomes.size(); ++k) {
    if (!std::isfinite(outcomes[k])) continue;  // the run failed
    outside += std::abs(outcomes[k] - forecasts[k].value) > 1.96 * std::sqrt(forecasts[k].variance);
    ++count;
  }
  // P(at least `outside`)
  return outside == 0 ||
         boost::math::cdf(boost::math::complement(boost::math::binomial(count, 0.05), outside - 1)) > 0.005;
}

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
  for (const auto& target : planned.targets) result.tolerance.push_back(target.tolerance);
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

  // Runs more points, of `starts` starts each, and keeps whether they are as predicted.
  bool held = false;
  const auto try_points = [&](const std::string& what, const Eigen::MatrixXd& more, int starts) {
    const auto name = [&](Eigen::Index k) { return fmt::format("{} {:02}", what, k); };
    std::vector<std::vector<Forecast>> expected(c.targets.size());
    study.variants.clear();
    for (Eigen::Index k = 0; k < more.rows(); ++k) {
      const auto list = forecasts(misfit, more.row(k).transpose(), starts);
      for (std::size_t i = 0; i < c.targets.size(); ++i) {
        expected[i].push_back(list[i]);
        study.variants.push_back(
            variant_at(study, name(k), more.row(k).transpose(), c.targets[i], starts, c.revolutions));
      }
    }
    if (!run()) return false;
    std::vector<std::vector<double>> outcomes(c.targets.size());
    for (Eigen::Index k = 0; k < more.rows(); ++k) {
      evidence.add(rows, name(k), more.row(k).transpose());
      const auto own = evidence.own(evidence.tried() - 1);
      for (std::size_t i = 0; i < c.targets.size(); ++i)
        outcomes[i].push_back(own ? own->logarithms[static_cast<Eigen::Index>(i)] : std::nan(""));
    }
    held = true;
    for (std::size_t i = 0; i < c.targets.size(); ++i)
      held = held && predictions_hold(expected[i], outcomes[i]);
    misfit = evidence.misfit(result);
    return true;
  };
  const auto refine = [&] {
    while (result.rounds < c.refinements) {
      const auto now = search(misfit, every, evidence.points());
      if (held && fine_enough(misfit, now)) break;
      if (!try_points(fmt::format("refinement {}", result.rounds), where_to_refine(misfit, now, 4 * n + 4),
                      c.starts))
        return false;
      ++result.rounds;
    }
    return true;
  };
  std::string last;  // name of the last points of the profile
  for (int round = 0; round <= profile_rounds; ++round) {
    if (!refine()) return result;
    const auto before = result.all.ends;
    result.all = fit(misfit, every, c.unknowns, evidence.points());
    const auto now = search(misfit, every, evidence.points());
    result.refined = fine_enough(misfit, now);
    result.all.settled = c.refinements == 0 || (held && fine_enough(misfit, now, false));
    double moved = round == 0 ? INFINITY : 0;
    for (Eigen::Index j = 0; round > 0 && j < n; ++j) {
      const auto at = [&](const Eigen::MatrixXd& ends, Eigen::Index end) { return ends(2 * j + end, j); };
      const double width = at(result.all.ends, 1) - at(result.all.ends, 0);
      for (Eigen::Index end : {0, 1})
        moved = std::max(moved, std::abs(at(before, end) - at(result.all.ends, end)) / std::max(width, 0.02));
    }
    if ((held && result.refined && moved < 0.15) || round == profile_rounds || c.refinements == 0) break;
    std::vector<Eigen::VectorXd> list{result.all.xi};
    for (const auto row : result.all.ends.rowwise()) list.push_back(row.transpose());
    const auto add = [&](const Eigen::VectorXd& xi) {
      constexpr double apart = 0.01;
      if (std::ranges::none_of(list,
                               [&](const Eigen::VectorXd& other) { return (other - xi).norm() < apart; }))
        list.push_back(xi);
    };
    for (std::size_t i = 0; i < c.targets.size() && c.targets.size() > 1 && c.leave_out; ++i) {
      auto used = every;
      used[i] = false;
      add(search(misfit, used, evidence.points()).best.xi);
    }
    // As many as in a refinement: the others where the surfaces need them.
    const auto doubtful = where_to_refine(misfit, now, 4 * n + 4);
    for (const auto row : doubtful.rowwise())
      if (static_cast<int>(list.size()) < 4 * n + 4) add(row.transpose());
    Eigen::MatrixXd more(list.size(), n);
    for (std::size_t k = 0; k < list.size(); ++k)
      more.row(static_cast<Eigen::Index>(k)) = list[k].transpose();
    last = fmt::format("profile {}", round);
    if (!try_points(last, more, std::max(c.starts, study.starts))) return result;
  }
  if (!held) result.all.rejected = result.all.rejected && no_run_meets(result.all, misfit, evidence);
  widen(result.all, misfit, evidence, c.unknowns);
  if (auto ridge = ridge_of(misfit, result.all, c.unknowns)) {
    if (!last.empty()) {
      const auto name = [&](std::size_t end) {
        return name_of_run(fmt::format("{} {:02}", last, 1 + 2 * ridge->along + end), c.targets.front());
      };
      separate(*ridge, c, rows, name(0), name(1));
    }
    result.ridge = std::move(ridge);
  }
  result.tried = evidence.tried();
  result.outcomes = evidence.outcomes();
  for (std::size_t y = 0; y < c.unknowns.size(); ++y)
    for (std::size_t x = 0; x < y; ++x)
      result.maps.push_back(
          {x, y, misfit_map(misfit, result.all, static_cast<Eigen::Index>(x), static_cast<Eigen::Index>(y))});
  for (std::size_t i = 0; i < c.targets.size(); ++i)
    result.at_optimum.push_back(misfit.parts(i, result.all.xi));
  if (c.targets.size() > 1 && c.leave_out)
    for (std::size_t i = 0; i < c.targets.size(); ++i) {
      auto used = every;
      used[i] = false;
      result.left_out.push_back(fit(misfit, used, c.unknowns, evidence.points()));
      result.left_out.back().settled = result.all.settled;
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
