#include "study/calibration/row_fit.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <iterator>
#include <map>
#include <numeric>
#include <random>
#include <stdexcept>

#include "io/scene/scene_text.hpp"
#include "measure/turns.hpp"

namespace freeplay {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Displacement of ξ for derivatives: far above the error of a run, and small against the ranges.
constexpr double displacement = 2e-3;
constexpr double least_step = 1e-4, least_gain = 1e-6;
constexpr int most_trials = 60;

/// A run without result where a fit needs one.
struct FailedRun : std::runtime_error {
  FailedRun() : std::runtime_error("a run failed at every start of the search or beside an accepted step") {}
};

/// d + Σ s_j slope_j of some rows.
struct LinearRows {
  MatrixXd d;
  std::vector<MatrixXd> slope;  // for each unknown

  MatrixXd at(const VectorXd& s) const {
    MatrixXd moved = d;
    for (Index j = 0; j < s.size(); ++j) moved += s[j] * slope[static_cast<std::size_t>(j)];
    return moved;
  }
};

/// Minimum of ½ sᵀHs + gᵀs within a box, by coordinate descent; H is positive semidefinite. A coordinate
/// without curvature stays at 0.
VectorXd least_in_box(const MatrixXd& H, const VectorXd& g, const VectorXd& low, const VectorXd& high) {
  VectorXd s = VectorXd::Zero(g.size());
  for (int sweep = 0; sweep < 200; ++sweep) {
    double change = 0;
    for (Index j = 0; j < g.size(); ++j) {
      if (!(H(j, j) > 0)) continue;
      const double next = std::clamp(s[j] - (g[j] + H.row(j).dot(s)) / H(j, j), low[j], high[j]);
      change = std::max(change, std::abs(next - s[j]));
      s[j] = next;
    }
    if (change < 1e-10) break;
  }
  return s;
}

/// s within a box that minimises Σ count_i |d_i + J_i s|.
VectorXd least_sum(const LinearRows& rows, const VectorXd& count, const VectorXd& low, const VectorXd& high) {
  const auto n = static_cast<Index>(rows.slope.size());
  VectorXd s = VectorXd::Zero(n);
  VectorXd norms = rows.d.rowwise().norm();
  const double floor = 1e-3 * norms.dot(count) / count.sum() + 1e-300;
  MatrixXd H(n, n);
  VectorXd g(n);
  for (int iteration = 0; iteration < 100; ++iteration) {
    const VectorXd weight = count.array() / norms.array().max(floor);
    for (Index j = 0; j < n; ++j) {
      const MatrixXd weighed = weight.asDiagonal() * rows.slope[static_cast<std::size_t>(j)];
      g[j] = weighed.cwiseProduct(rows.d).sum();
      for (Index k = 0; k <= j; ++k)
        H(j, k) = H(k, j) = weighed.cwiseProduct(rows.slope[static_cast<std::size_t>(k)]).sum();
    }
    const VectorXd next = least_in_box(H, g, low, high);
    const double change = n > 0 ? (next - s).cwiseAbs().maxCoeff() : 0;
    s = next;
    norms = rows.at(s).rowwise().norm();
    if (change < 0.1 * least_step) break;
  }
  return s;
}

/// Random draws of places from 0 to n − 1, with replacement.
class Draws {
 public:
  explicit Draws(std::uint64_t seed) : engine_(seed) {}
  std::size_t below(std::size_t n) {
    return std::min(n - 1, static_cast<std::size_t>(static_cast<double>(engine_() >> 11) * 0x1p-53 *
                                                    static_cast<double>(n)));
  }

 private:
  std::mt19937_64 engine_;
};

/// Whether an unknown has no influence here: its whole range of 2 changes S by less than a thousandth.
bool is_flat(const MatrixXd& slope, const MatrixXd& d) {
  return 2 * slope.rowwise().norm().sum() <= 1e-3 * d.rowwise().norm().sum();
}

/// Sets the intervals of a fit from its linear model at the optimum.
void add_intervals(RowFit& fit, const LinearRows& rows, const std::vector<Unknown>& unknowns,
                   const Resampling& resampling) {
  const auto n = static_cast<Index>(unknowns.size());
  const VectorXd low = -VectorXd::Ones(n) - fit.xi, high = VectorXd::Ones(n) - fit.xi;
  const auto count = static_cast<std::size_t>(rows.d.rows());
  MatrixXd fits(n, resampling.count);  // a column for each draw
  const auto fit_to_draw = [&](std::size_t b) {
    Draws draws(resampling.seed + b);
    VectorXd times = VectorXd::Zero(rows.d.rows());
    for (std::size_t i = 0; i < count; ++i) times[static_cast<Index>(draws.below(count))] += 1;
    fits.col(static_cast<Index>(b)) = fit.xi + least_sum(rows, times, low, high);
  };
  if (n > 0) execute_jobs(resampling.threads, static_cast<std::size_t>(resampling.count), {}, fit_to_draw);
  for (std::size_t j = 0; j < unknowns.size(); ++j) {
    const auto row = fits.row(static_cast<Index>(j));
    const std::vector<double> drawn(row.begin(), row.end());
    const double from = quantile_of(drawn, 0.025), to = quantile_of(drawn, 0.975);
    const bool free = is_flat(rows.slope[j], rows.d);
    constexpr double end = 1 - 1e-6;
    fit.unknowns.push_back({unscaled(unknowns[j], fit.xi[static_cast<Index>(j)]),
                            unscaled(unknowns[j], free ? -1 : std::max(from, -1.0)),
                            unscaled(unknowns[j], free ? 1 : std::min(to, 1.0)), free || from <= -end,
                            free || to >= end});
  }
}

double sum_of_norms(const MatrixXd& d) { return d.allFinite() ? d.rowwise().norm().sum() : INFINITY; }

/// Improves ξ by up to two searches along each of these unknowns in turn, over a dozen values of its whole range. A
/// descent from one start may be on a plateau, such as friction at which all contacts stick, or end in a minimum
/// that is not the least one.
VectorXd scanned(const RowModel& model, std::span<const std::size_t> rows, VectorXd xi,
                 const std::vector<Index>& along) {
  constexpr int values = 12, sweeps = 2;
  double least = sum_of_norms(model(rows, xi));
  bool changed = true;
  for (int sweep = 0; sweep < sweeps && changed; ++sweep) {
    changed = false;
    for (const Index j : along)
      for (int i = 0; i < values; ++i) {
        auto other = xi;
        other[j] = (2.0 * i + 1) / values - 1;
        if (const double now = sum_of_norms(model(rows, other)); now < least)
          least = now, xi = other, changed = true;
      }
  }
  return xi;
}

/// At most forty of the rows, evenly spaced.
std::vector<std::size_t> some_of(std::span<const std::size_t> rows) {
  const auto count = std::min<std::size_t>(40, rows.size());
  std::vector<std::size_t> some;
  for (std::size_t k = 0; k < count; ++k) some.push_back(rows[k * rows.size() / count]);
  return some;
}

}  // namespace

double quantile_of(std::vector<double> list, double p) {
  std::ranges::sort(list);
  return quantile(list, p);
}

RowFit fit_rows(const RowModel& model, std::span<const std::size_t> rows,
                const std::vector<Unknown>& unknowns, const Resampling& resampling) {
  const auto n = static_cast<Index>(unknowns.size());
  RowFit fit;
  std::vector<Index> all(unknowns.size()),
      wide;  // wide: a range over which the misfit may have several minima
  std::iota(all.begin(), all.end(), Index{0});
  std::ranges::copy_if(all, std::back_inserter(wide),
                       [&](Index j) { return unknowns[static_cast<std::size_t>(j)].logarithmic; });
  fit.xi = scanned(model, some_of(rows), VectorXd::Zero(n), all);
  const auto known = [&](const VectorXd& xi) {
    auto d = model(rows, xi);
    if (!d.allFinite()) throw FailedRun();
    return d;
  };
  const auto linear_at = [&](MatrixXd d) {
    LinearRows linear{std::move(d), {}};
    for (Index j = 0; j < n; ++j) {
      VectorXd beside = fit.xi;
      const double h = fit.xi[j] > 0 ? -displacement : displacement;
      beside[j] += h;
      linear.slope.emplace_back((known(beside) - linear.d) / h);
    }
    return linear;
  };
  auto linear = linear_at(known(fit.xi));
  constexpr double first_radius = 0.25;
  double now = sum_of_norms(linear.d), radius = first_radius;
  bool searched = false;
  const VectorXd once = VectorXd::Ones(linear.d.rows());
  for (int step = 0; step < most_trials && !fit.settled; ++step) {
    const VectorXd low = (-VectorXd::Ones(n) - fit.xi).cwiseMax(-radius);
    const VectorXd high = (VectorXd::Ones(n) - fit.xi).cwiseMin(radius);
    const VectorXd s = least_sum(linear, once, low, high);
    const double length = n > 0 ? s.cwiseAbs().maxCoeff() : 0, gain = now - sum_of_norms(linear.at(s));
    fit.settled = length < least_step || !(gain > least_gain * now);
    if (fit.settled &&
        !searched) {  // once: by all rows, from an unknown without influence or another minimum
      searched = true;
      const bool on_plateau =
          std::ranges::any_of(linear.slope, [&](const auto& slope) { return is_flat(slope, linear.d); });
      const auto& along = on_plateau ? all : wide;
      const auto place = along.empty() ? fit.xi : scanned(model, rows, fit.xi, along);
      if (place == fit.xi) break;
      if (auto d = known(place); sum_of_norms(d) < now) {
        fit.settled = false;
        fit.xi = place;
        radius = first_radius;
        now = sum_of_norms(d);
        linear = linear_at(std::move(d));
        continue;
      }
    }
    if (fit.settled) break;
    const VectorXd next = (fit.xi + s).cwiseMax(-1).cwiseMin(1);
    auto d = model(rows, next);  // a run that fails shortens the step
    const double then = sum_of_norms(d);
    if (now - then >= 0.1 * gain) {
      if (now - then > 0.75 * gain) radius = std::min(2.0, 2 * radius);
      fit.xi = next;
      now = then;
      linear = linear_at(std::move(d));
      ++fit.iterations;
    } else {
      radius = 0.25 * length;
    }
  }
  const VectorXd norms = linear.d.rowwise().norm();
  fit.residuals.assign(norms.begin(), norms.end());
  add_intervals(fit, linear, unknowns, resampling);
  return fit;
}

namespace {

/// Runs of the rows in one variant and formulation.
class RowRuns {
 public:
  RowRuns(const Study& study, const RowTable& table, const Variant& variant, const std::string& formulation,
          const std::vector<Unknown>& unknowns, const Conduct& conduct, int threads)
      : study_(study), table_(table), unknowns_(unknowns), conduct_(conduct), threads_(threads) {
    case_.variant = variant.name;
    case_.formulation = formulation;
    case_.revolutions = variant.revolutions;
    case_.scene = variant.scene;
    case_.overrides = variant.overrides;
    const VectorXd middle = VectorXd::Zero(static_cast<Index>(unknowns.size()));
    // Errors of keys and columns have their places in the study.
    at_line(0, [&] { require_runnable(study_, at_row(0, middle), conduct_); });
    const auto text = read_text(variant.scene);
    for (std::size_t i = 0; i < table.size(); ++i)
      texts_.push_back(at_line(i, [&] {
        return std::make_shared<const SceneText>(text, variant.scene.string(), with_row(i),
                                                 study.reach == Reach::anywhere);
      }));
    for (const auto& t : study.rows->targets)
      measures_.push_back(static_cast<std::size_t>(std::ranges::find(study.measures, t.name, &Measure::name) -
                                                   study.measures.begin()));
  }

  MatrixXd operator()(std::span<const std::size_t> rows, const VectorXd& xi) {
    const auto& targets = study_.rows->targets;
    MatrixXd d = MatrixXd::Constant(static_cast<Index>(rows.size()), static_cast<Index>(targets.size()), NAN);
    execute_jobs(threads_, rows.size(), conduct_.stop, [&](std::size_t k) {
      const auto row = rows[k];
      const auto result = at_line(row, [&] { return run_case(study_, at_row(row, xi), conduct_); });
      if (result.ending.status != Ending::Status::finished) return;
      for (std::size_t t = 0; t < targets.size(); ++t) {
        const auto column = static_cast<Index>(t);
        d(static_cast<Index>(k), column) =
            targets[t].weight *
            (result.measured[measures_[t]].value - table_.measured(static_cast<Index>(row), column));
      }
    });
    if (conduct_.stop()) throw Interrupted();
    made += static_cast<long>(rows.size());
    return d;
  }

  long made = 0;  ///< number of runs

 private:
  /// Returns f(); an error of a row's scene names its line.
  template <class F>
  auto at_line(std::size_t row, const F& f) const -> decltype(f()) try {
    return f();
  } catch (const ModelError& e) {
    throw SceneError(fmt::format("{}: line {}: {}", study_.rows->file.string(), table_.lines[row], e.what()));
  }
  std::vector<std::string> with_row(std::size_t row) const {
    auto all = case_.overrides;
    all.insert(all.end(), table_.settings[row].begin(), table_.settings[row].end());
    return all;
  }
  Case at_row(std::size_t row, const VectorXd& xi) const {
    auto one = case_;
    one.overrides = with_row(row);
    for (std::size_t j = 0; j < unknowns_.size(); ++j)
      one.overrides.push_back(
          fmt::format("{}={}", unknowns_[j].key, unscaled(unknowns_[j], xi[static_cast<Index>(j)])));
    if (row < texts_.size()) one.text = texts_[row];
    return one;
  }

  const Study& study_;
  const RowTable& table_;
  std::vector<Unknown> unknowns_;
  Conduct conduct_;
  int threads_;
  Case case_;
  std::vector<std::shared_ptr<const SceneText>> texts_;  // of the rows, parsed once
  std::vector<std::size_t> measures_;                    // of the targets
};

}  // namespace

std::vector<RowPrediction> predict_rows(const Study& given, const RowTable& table, bool hold_out,
                                        const Conduct& conduct, int threads,
                                        const std::function<void(const std::string&, double)>& on_progress) {
  if (hold_out && static_cast<int>(table.size()) < given.rows->parts)
    throw SceneError(
        fmt::format("{}: has {} rows that are used, fewer than the {} parts of rows.hold_out that "
                    "are predicted; calibrate needs no parts",
                    given.rows->file.string(), table.size(), given.rows->parts));
  auto study = given;
  study.starts.perturbation = {.turn = 0, .play = 0, .vary = {}};  // each row states its start
  const Resampling resampling{study.rows->resamples, study.starts.seed, threads};
  std::vector<RowPrediction> all;
  double models = 0;
  for (const auto& v : study.variants) models += static_cast<double>(v.formulations.size());
  for (const auto& variant : study.variants)
    for (const auto& formulation : variant.formulations) {
      RowPrediction p;
      p.variant = variant.name;
      p.title = variant.title;
      p.formulation = formulation;
      for (const auto& u : study.rows->unknowns)
        if (std::ranges::count(variant.unknowns, u.name) > 0) p.unknowns.push_back(u);
      if (on_progress) on_progress(p.name(), static_cast<double>(all.size()) / models);
      RowRuns runs(study, table, variant, formulation, p.unknowns, conduct, threads);
      const auto model = [&](std::span<const std::size_t> rows, const VectorXd& xi) {
        return runs(rows, xi);
      };
      const auto fails = [&](const std::string& why) {
        return SceneError(fmt::format("{}: {}: {}", study.rows->file.string(), p.name(), why));
      };
      if (hold_out) {
        p.residual.resize(table.size());
        p.difference.resize(table.measured.rows(), table.measured.cols());
      }
      for (int part = 0; part < (hold_out ? study.rows->parts : 1); ++part) {
        std::vector<std::size_t> fitted, held;
        for (std::size_t i = 0; i < table.size(); ++i)
          (hold_out && table.part[i] == part ? held : fitted).push_back(i);
        try {
          p.fits.push_back(fit_rows(model, fitted, p.unknowns, resampling));
        } catch (const FailedRun& e) {
          throw fails(e.what());
        }
        if (held.empty()) continue;
        const auto d = runs(held, p.fits.back().xi);
        for (std::size_t k = 0; k < held.size(); ++k) {
          const auto row = d.row(static_cast<Index>(k));
          if (!row.allFinite()) throw fails(fmt::format("the run of line {} failed", table.lines[held[k]]));
          p.difference.row(static_cast<Index>(held[k])) = row;
          p.residual[held[k]] = row.norm();
        }
      }
      p.runs = runs.made;
      all.push_back(std::move(p));
    }
  return all;
}

namespace {

/// Summaries of these rows for all predictions, the best one marked.
void add_summaries(std::vector<RowSummary>& all, const std::string& name,
                   const std::vector<std::size_t>& rows, const std::vector<RowPrediction>& predictions,
                   const Resampling& resampling) {
  const auto first = all.size();
  std::vector<std::vector<double>> medians(predictions.size());
  Draws draws(resampling.seed);
  std::vector<std::size_t> drawn(rows.size());
  const auto of = [&](const RowPrediction& p, const std::vector<std::size_t>& places) {
    std::vector<double> list;
    for (const auto i : places) list.push_back(p.residual[i]);
    return list;
  };
  for (int b = 0; b < resampling.count; ++b) {
    for (auto& place : drawn) place = rows[draws.below(rows.size())];
    for (std::size_t m = 0; m < predictions.size(); ++m)
      medians[m].push_back(quantile_of(of(predictions[m], drawn), 0.5));
  }
  std::size_t best = 0;
  for (std::size_t m = 0; m < predictions.size(); ++m) {
    const auto own = of(predictions[m], rows);
    RowSummary s;
    s.model = m;
    s.rows = name;
    s.count = rows.size();
    s.median = {.value = quantile_of(own, 0.5),
                .low = quantile_of(medians[m], 0.025),
                .high = quantile_of(medians[m], 0.975)};
    s.ninety = quantile_of(own, 0.9);
    for (Index k = 0; k < predictions[m].difference.cols(); ++k) {
      double total = 0;
      for (const auto i : rows) total += predictions[m].difference(static_cast<Index>(i), k);
      s.mean.push_back(total / static_cast<double>(rows.size()));
    }
    all.push_back(std::move(s));
    if (all.back().median.value < all[first + best].median.value) best = m;
  }
  all[first + best].best = true;
  for (std::size_t m = 0; m < predictions.size(); ++m) {
    auto excess = medians[m];
    for (std::size_t b = 0; b < excess.size(); ++b) excess[b] -= medians[best][b];
    all[first + m].worse = m != best && quantile_of(excess, 0.025) > 0;
  }
}

}  // namespace

std::vector<RowSummary> summaries(const Study& study, const RowTable& table,
                                  const std::vector<RowPrediction>& predictions) {
  constexpr std::size_t fewest = 10;  // below, a 90 % quantile is the greatest value
  const Resampling resampling{study.rows->resamples, study.starts.seed, 1};
  std::vector<RowSummary> all;
  std::vector<std::size_t> rows(table.size());
  std::iota(rows.begin(), rows.end(), std::size_t{0});
  add_summaries(all, "all rows", rows, predictions, resampling);
  for (std::size_t c = 0; c < study.rows->classes.size(); ++c) {
    const auto& classes = study.rows->classes[c];
    std::map<int, std::vector<std::size_t>> members;
    for (std::size_t i = 0; i < table.size(); ++i)
      members[class_of(classes, table.values[c][i])].push_back(i);
    for (const auto& [number, list] : members)
      if (list.size() >= fewest)
        add_summaries(all, class_name(classes, number), list, predictions, resampling);
  }
  return all;
}

}  // namespace freeplay
