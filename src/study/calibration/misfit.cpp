#include "study/calibration/misfit.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <Eigen/Cholesky>

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include "numerics/quantiles.hpp"

namespace freeplay {
namespace {

double weight(const Eigen::VectorXd& a, const Eigen::VectorXd& b, const Eigen::VectorXd& widths) {
  return std::exp(-0.5 * (a - b).cwiseQuotient(widths).squaredNorm());
}

constexpr std::array shares{0.2, 0.3, 0.45, 0.7, 1.0, 1.5};  // of ½√n

}  // namespace

void Scatter::add(const Eigen::VectorXd& xi, const Eigen::MatrixXd& outcomes) {
  if (outcomes.rows() < 2) return;
  if (points_.empty())
    widths_ = Eigen::VectorXd::Constant(xi.size(), 0.5 * std::sqrt(static_cast<double>(xi.size())));
  const Eigen::RowVectorXd mean = outcomes.colwise().mean();
  const Eigen::MatrixXd r = (outcomes.rowwise() - mean).array().rowwise() / mean.array();
  points_.push_back({xi, r.transpose() * r, static_cast<double>(outcomes.rows() - 1)});
}

double Scatter::prediction(const Eigen::VectorXd& widths) const {
  Eigen::VectorXd mean = Eigen::VectorXd::Zero(points_.front().squares.rows());
  double all = 0, sum = 0;
  for (const auto& p : points_) {
    mean += p.squares.diagonal();
    all += p.freedom;
  }
  mean /= all;
  for (const auto& p : points_) {
    Eigen::VectorXd w = Eigen::VectorXd::Zero(mean.size());
    double known = 0;
    for (const auto& q : points_) {
      if (&p == &q) continue;
      const double k = weight(p.xi, q.xi, widths);
      w += k * q.squares.diagonal();
      known += k * q.freedom;
    }
    for (Eigen::Index i = 0; i < mean.size(); ++i) {
      if (mean[i] == 0) continue;  // no scatter
      const double here = std::max(known > 0 ? w[i] / known : 0.0, 1e-9 * mean[i]);
      sum -= 0.5 * (p.freedom * std::log(here) + p.squares(i, i) / here);
    }
  }
  return sum;
}

void Scatter::choose_widths() {
  if (points_.size() < 3) return;
  const double whole = 0.5 * std::sqrt(static_cast<double>(widths_.size()));
  double best = prediction(widths_);
  for (int cycle = 0; cycle < 2; ++cycle)
    for (Eigen::Index j = 0; j < widths_.size(); ++j) {
      Eigen::VectorXd widths = widths_;
      for (const double share : shares) {
        widths[j] = share * whole;
        if (const double here = prediction(widths); here > best) {
          best = here;
          widths_ = widths;
        }
      }
    }
}

Scatter::Local Scatter::at(const Eigen::VectorXd& xi) const {
  const auto m = points_.front().squares.rows();
  Local local{Eigen::MatrixXd::Zero(m, m), 0};
  double known = 0, squares = 0;
  for (const auto& p : points_) {
    const double k = weight(xi, p.xi, widths_);
    local.covariance += k * p.squares;
    known += k * p.freedom;
    squares += k * k * p.freedom;
  }
  local.covariance /= known;
  local.freedom = known * known / squares;
  const Eigen::VectorXd s = local.covariance.diagonal().cwiseSqrt();
  double numerator = 0, denominator = 0;
  const auto correlation = [&](Eigen::Index i, Eigen::Index j) {
    return s[i] > 0 && s[j] > 0 ? local.covariance(i, j) / (s[i] * s[j]) : 0.0;
  };
  for (Eigen::Index i = 0; i < m; ++i)
    for (Eigen::Index j = 0; j < i; ++j) {
      const double r = correlation(i, j);
      numerator += std::pow(1 - r * r, 2) / local.freedom;
      denominator += r * r;
    }
  const double kept = denominator > 0 ? 1 - std::min(1.0, numerator / denominator) : 0;
  for (Eigen::Index i = 0; i < m; ++i)
    for (Eigen::Index j = 0; j < m; ++j)
      if (i != j) local.covariance(i, j) *= kept;
  return local;
}

namespace {

std::vector<std::size_t> places(const std::vector<bool>& used) {
  std::vector<std::size_t> list;
  for (std::size_t i = 0; i < used.size(); ++i)
    if (used[i]) list.push_back(i);
  return list;
}

}  // namespace

Misfit::Parts Misfit::parts(std::size_t target, const Eigen::VectorXd& xi) const {
  const auto& t = targets_[target];
  const auto& runs = scatter_[static_cast<std::size_t>(t.runs)];
  const auto of_mean = [&](double scatter) { return scatter * t.stretches.share(scatter); };
  const double surface = t.surface.variance(xi);
  if (!runs.known()) return {of_mean(t.surface.noise()), surface, t.surface.freedom(), t.surface.noise()};
  const auto local = runs.at(xi);
  const double run = local.covariance(t.column, t.column);
  return {of_mean(run), surface, local.freedom, run};
}

double Misfit::freedom(const Eigen::VectorXd& xi, const std::vector<bool>& used) const {
  double fewest = INFINITY;
  for (const auto i : places(used)) {
    const auto p = parts(i, xi);
    const double whole = p.scatter + p.surface + std::pow(targets_[i].tolerance, 2);
    const double doubt =
        std::pow(p.scatter, 2) / p.freedom + std::pow(p.surface, 2) / targets_[i].surface.freedom();
    if (doubt > 1e-9 * whole * whole) fewest = std::min(fewest, whole * whole / doubt);
  }
  return fewest;
}

Misfit::At Misfit::at(const Eigen::VectorXd& xi, const std::vector<bool>& used, const Own* own) const {
  const auto list = places(used);
  const auto m = static_cast<Eigen::Index>(list.size());
  At a{Eigen::VectorXd(m), Eigen::MatrixXd::Zero(m, m), 0, pull * xi.squaredNorm()};
  Eigen::MatrixXd measurement = Eigen::MatrixXd::Zero(m, m);  // U
  std::vector<std::optional<Scatter::Local>> local(scatter_.size());
  Eigen::VectorXd s(m), share(m);
  for (Eigen::Index i = 0; i < m; ++i) {
    const auto& t = targets_[list[i]];
    a.residual[i] = t.logarithm - (own ? own->logarithms[static_cast<Eigen::Index>(list[i])] : t.surface(xi));
    auto& w = local[static_cast<std::size_t>(t.runs)];
    const auto& runs = scatter_[static_cast<std::size_t>(t.runs)];
    if (!w && runs.known()) w = runs.at(xi);
    const double scatter = w ? w->covariance(t.column, t.column) : t.surface.noise();
    s[i] =
        std::sqrt(own ? scatter / own->starts[static_cast<Eigen::Index>(list[i])] : t.surface.variance(xi));
    share[i] = t.stretches.share(scatter);
    measurement(i, i) = scatter * share[i] + t.tolerance * t.tolerance;
    a.covariance(i, i) = measurement(i, i) + s[i] * s[i];
    for (Eigen::Index j = 0; j < i; ++j) {
      const auto& u = targets_[list[j]];
      if (u.runs != t.runs || !w) continue;
      const double size = std::sqrt(w->covariance(t.column, t.column) * w->covariance(u.column, u.column));
      if (size == 0) continue;
      const double both = w->covariance(t.column, u.column);
      if (u.source == t.source) measurement(i, j) = measurement(j, i) = both * std::sqrt(share[i] * share[j]);
      a.covariance(i, j) = a.covariance(j, i) = measurement(i, j) + both / size * s[i] * s[j];
    }
  }
  if (m == 0) return a;
  a.squares = a.residual.dot(a.covariance.ldlt().solve(a.residual));
  a.value += a.squares + Eigen::LDLT<Eigen::MatrixXd>(measurement).vectorD().array().max(1e-300).log().sum();
  return a;
}

Eigen::MatrixXd Misfit::jacobian(const Eigen::VectorXd& xi, const std::vector<bool>& used) const {
  const auto list = places(used);
  Eigen::MatrixXd J(static_cast<Eigen::Index>(list.size()), xi.size());
  for (std::size_t i = 0; i < list.size(); ++i)
    J.row(static_cast<Eigen::Index>(i)) = targets_[list[i]].surface.gradient(xi).transpose();
  return J;
}

Identifiability identifiability(const Misfit& misfit, const Eigen::MatrixXd& points) {
  const auto n = points.cols();
  const auto m = static_cast<Eigen::Index>(misfit.targets().size());
  const std::vector<bool> all(misfit.targets().size(), true);
  Identifiability found;
  found.sensitivity = Eigen::MatrixXd::Zero(m, n);
  Eigen::MatrixXd mean = Eigen::MatrixXd::Zero(n, n);
  std::vector<std::vector<double>> widths(static_cast<std::size_t>(n));
  // The surfaces at many places, each of which could be met if the truth were a point of the design.
  const auto places = space_filling(static_cast<int>(n), 256 * static_cast<int>(n));
  Eigen::MatrixXd outcomes(m, places.rows());
  std::vector<Eigen::MatrixXd> precision;
  for (Eigen::Index q = 0; q < places.rows(); ++q) {
    const auto at = misfit.at(places.row(q).transpose(), all);
    for (Eigen::Index i = 0; i < m; ++i)
      outcomes(i, q) = misfit.targets()[static_cast<std::size_t>(i)].logarithm - at.residual[i];
    precision.push_back(at.covariance.ldlt().solve(Eigen::MatrixXd::Identity(m, m)));
  }
  for (Eigen::Index p = 0; p < points.rows(); ++p) {
    const Eigen::VectorXd xi = points.row(p).transpose();
    const auto J = misfit.jacobian(xi, all);
    const auto at = misfit.at(xi, all);
    const auto& V = at.covariance;
    const Eigen::MatrixXd information =
        J.transpose() * V.ldlt().solve(J) + Misfit::pull * Eigen::MatrixXd::Identity(n, n);
    mean += information / static_cast<double>(points.rows());
    found.sensitivity +=
        (V.diagonal().cwiseInverse().asDiagonal() * J.cwiseAbs2()) / static_cast<double>(points.rows());
    const Eigen::MatrixXd covariance = information.inverse();
    Eigen::VectorXd low = xi - 1.96 * covariance.diagonal().cwiseSqrt(),
                    high = xi + 1.96 * covariance.diagonal().cwiseSqrt();
    low = low.cwiseMax(-1);
    high = high.cwiseMin(1);
    Eigen::VectorXd here(m);
    for (Eigen::Index i = 0; i < m; ++i)
      here[i] = misfit.targets()[static_cast<std::size_t>(i)].logarithm - at.residual[i];
    for (Eigen::Index q = 0; q < places.rows(); ++q) {
      const Eigen::VectorXd apart = outcomes.col(q) - here, place = places.row(q).transpose();
      if (apart.dot(precision[static_cast<std::size_t>(q)] * apart) +
              Misfit::pull * (place - xi).squaredNorm() >
          1.96 * 1.96)
        continue;
      low = low.cwiseMin(place);
      high = high.cwiseMax(place);
    }
    for (Eigen::Index j = 0; j < n; ++j)
      widths[static_cast<std::size_t>(j)].push_back(0.5 * (high[j] - low[j]));
  }
  found.sensitivity = found.sensitivity.cwiseSqrt();
  for (auto& list : widths) {
    std::ranges::nth_element(list, list.begin() + static_cast<std::ptrdiff_t>(list.size() / 2));
    found.left_open.push_back(list[list.size() / 2]);
  }
  const Eigen::MatrixXd covariance = mean.inverse();
  const Eigen::VectorXd scale = covariance.diagonal().cwiseSqrt().cwiseInverse();
  found.correlation = scale.asDiagonal() * covariance * scale.asDiagonal();
  return found;
}

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

bool predictions_hold(const std::vector<Forecast>& forecasts, const std::vector<double>& outcomes) {
  int count = 0, outside = 0;
  for (std::size_t k = 0; k < outcomes.size(); ++k) {
    if (!std::isfinite(outcomes[k])) continue;  // the run failed
    outside += std::abs(outcomes[k] - forecasts[k].value) > 1.96 * std::sqrt(forecasts[k].variance);
    ++count;
  }
  // P(at least `outside`)
  return outside == 0 || binomial_above(count, 0.05, outside - 1) > 0.005;
}

std::vector<std::string> overrides_at(const Calibration& c, const Eigen::VectorXd& xi) {
  std::vector<std::string> list;
  for (std::size_t j = 0; j < c.unknowns.size(); ++j)
    list.push_back(
        fmt::format("{}={}", c.unknowns[j].key, unscaled(c.unknowns[j], xi[static_cast<Eigen::Index>(j)])));
  return list;
}

Eigen::MatrixXd as_rows(const std::vector<Eigen::VectorXd>& rows) {
  Eigen::MatrixXd all(rows.size(), rows.front().size());
  for (std::size_t p = 0; p < rows.size(); ++p) all.row(static_cast<Eigen::Index>(p)) = rows[p].transpose();
  return all;
}

TargetStatistic statistic_of(const Study& study, const Target& target) {
  const auto& names = TurnMetrics::names();
  const auto measure = std::ranges::find(study.measures, target.measure(), &Measure::name);
  if (measure != study.measures.end())
    return {TurnMetrics::count, static_cast<std::size_t>(measure - study.measures.begin())};
  return {static_cast<TurnMetrics::Name>(std::ranges::find(names, target.statistic) - names.begin())};
}

std::string name_of_run(const std::string& what, const Target& target) {
  std::string name = fmt::format("{} {}", what, fmt::join(target.overrides, " "));
  if (target.sampling > 0) name += fmt::format(" {} Hz {} turns", target.sampling, target.turns);
  if (target.noise > 0) name += fmt::format(" +- {} m/s2", target.noise);
  return name;
}

Evidence::Evidence(const Study& study, const Calibration& c, const std::vector<double>& measured)
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

void Evidence::add(const std::vector<RunRow>& rows, const std::string& point, const Eigen::VectorXd& xi) {
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

std::optional<Misfit::Own> Evidence::own(int point) const {
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

std::vector<Evidence::Outcome> Evidence::outcomes() const {
  std::vector<Outcome> all;
  for (const auto& r : runs_)
    for (std::size_t k = 0; k < r.targets.size(); ++k)
      for (std::size_t p = 0; p < r.xi.size(); ++p)
        all.push_back({r.targets[k], r.xi[p], r.outcomes[p].col(static_cast<Eigen::Index>(k)).mean()});
  return all;
}

Misfit Evidence::misfit() const {
  std::vector<std::optional<Observed>> observed(c_.targets.size());
  std::vector<Scatter> scatter;
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
    }
  }
  std::vector<Observed> list;
  for (auto& o : observed) list.push_back(std::move(*o));
  return {std::move(list), std::move(scatter)};
}

void Evidence::require_positive(const Runs& r, std::size_t column) const {
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

ResponseSurface Evidence::surface(const Runs& r, std::size_t column, const Scatter& scatter,
                                  const Target& target) const {
  const auto n = static_cast<int>(c_.unknowns.size());
  const auto count = static_cast<Eigen::Index>(r.xi.size());
  if (count < ResponseSurface::coefficients(n) + 2)
    throw std::runtime_error(
        fmt::format("calibration: the runs at {} of {} points failed for {}; {} points are needed",
                    tried() - count, tried(), target.name, ResponseSurface::coefficients(n) + 2));
  Eigen::VectorXd y(count), noise = Eigen::VectorXd::Ones(count);
  for (Eigen::Index p = 0; p < count; ++p) {
    const auto& outcomes = r.outcomes[static_cast<std::size_t>(p)];
    const auto k = static_cast<Eigen::Index>(column);
    y[p] = std::log(outcomes.col(k).mean());
    if (scatter.known()) noise[p] = scatter.at(r.xi[static_cast<std::size_t>(p)]).covariance(k, k);
    noise[p] /= static_cast<double>(outcomes.rows());
  }
  // Relative; equal where nothing scatters.
  const double mean = noise.mean();
  noise = mean > 0 ? Eigen::VectorXd((noise / mean).cwiseMax(1e-3)) : Eigen::VectorXd::Ones(count);
  return {as_rows(r.xi), y, noise, scatter.known() ? mean : -1};
}

}  // namespace freeplay
