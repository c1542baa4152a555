#include "study/calibration/calibrate.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "numerics/quantiles.hpp"
#include "study/calibration/agreement.hpp"

namespace freeplay {
namespace {

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
  std::ranges::copy(overrides_at(c, xi), std::back_inserter(v.overrides));
  return v;
}

/// Values of a statistic, one for each run.
std::vector<double> outcomes_of(const std::vector<RunRow>& rows, const std::string& variant,
                                const TargetStatistic& statistic) {
  std::vector<double> list;
  for (const auto& r : rows)
    if (r.variant == variant) list.push_back(statistic.of(r));
  return list;
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
  return as_rows(chosen);
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
  const double most = chi_squared_quantile(fit.degrees, 0.99);
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
  if (outcomes.empty() || !std::ranges::all_of(outcomes, [](double x) { return x > 0; })) return true;
  const auto n = static_cast<double>(outcomes.size());
  double mean = 0, squares = 0;
  for (double x : outcomes) mean += std::log(x) / n;
  for (double x : outcomes) squares += std::pow(std::log(x) - mean, 2);
  const double normal = normal_quantile(0.995);
  const double one = n > 1 ? student_quantile(n - 1, 0.995) *
                                 std::sqrt((stretches.share(squares / (n - 1)) + 1 / n) * squares / (n - 1))
                           : normal * surface_error;
  // For a single start, `one` contains it.
  const double surface = n > 1 ? normal * surface_error : 0;
  return std::abs(std::log(measured) - mean) > std::hypot(normal * tolerance, one, surface);
}

CalibrationPlan plan_calibration(const Study& study, const Conduct& conduct) {
  if (!study.calibration) throw SceneError(fmt::format("{}: has no [calibrate]", study.file.string()));
  const auto& c = *study.calibration;
  if (const auto& t = c.targets.front(); t.is_quantity() || t.is_series())
    throw SceneError(fmt::format(
        "{}: calibrate.targets.{}: \"{}\" is {} of one run; only `freeplay calibrate` on one machine fits "
        "those",
        study.file.string(), t.name, t.statistic, t.is_series() ? "a series" : "a quantity"));
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
  auto misfit = evidence.misfit();
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
    misfit = evidence.misfit();
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
    last = fmt::format("profile {}", round);
    if (!try_points(last, as_rows(list), std::max(c.starts, study.starts.count))) return result;
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
  for (std::size_t i = 0; i < c.targets.size(); ++i) {
    const auto& surface = misfit.targets()[i].surface;
    result.points.push_back(surface.points());
    result.surface_error.push_back(surface.error());
    result.surface_spread.push_back(surface.spread());
    result.at_optimum.push_back(misfit.parts(i, result.all.xi));
  }
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
      study.variants.push_back(
          variant_at(study, name, f->xi, target, study.starts.count, study.length.revolutions));
      for (int k = 0; k < draws; ++k)
        study.variants.push_back(variant_at(study, draw_name(name, k), f->draws.row(k).transpose(), target, 1,
                                            study.length.revolutions));
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
