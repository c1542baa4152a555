#include "study/calibration/quantity_fit.hpp"

#include <fmt/format.h>
#include <coin/IpIpoptApplication.hpp>
#include <coin/IpTNLP.hpp>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <map>
#include <stdexcept>

#include "analysis/sensitivity.hpp"
#include "io/scene/read_scene.hpp"
#include "mechanism/error.hpp"
#include "mechanism/scene.hpp"
#include "numerics/quantiles.hpp"

namespace freeplay {
namespace {

using Index = Eigen::Index;
using Vector = Eigen::VectorXd;
using Matrix = Eigen::MatrixXd;

/// N of event.N.PART; 0 for other quantities.
int event_of(const std::string& quantity) {
  int n = 0;
  if (quantity.starts_with("event.")) std::from_chars(&quantity[6], quantity.data() + quantity.size(), n);
  return n;
}

/// Quantities and derivatives at one ξ.
struct Point {
  Vector values;               // of the targets
  Matrix slopes;               // ∂Q/∂ξ, a row for each target
  std::vector<Vector> times;   // for each group of runs: of the contact events from 1
  std::vector<Matrix> motion;  // their derivatives
  std::string reason;          // why a value or derivative is missing; empty: none is
};

/// Runs of the model. Targets with the same `set` share a run.
class Model {
 public:
  Model(const Study& study, const StopToken& stop, const std::function<void(int)>& on_run)
      : study_(study), c_(*study.calibration), stop_(stop), on_run_(on_run), group_(c_.targets.size()) {
    for (std::size_t i = 0; i < c_.targets.size(); ++i) {
      const auto same = std::ranges::find(groups_, c_.targets[i].overrides, &Group::overrides);
      group_[i] = static_cast<std::size_t>(same - groups_.begin());
      if (same == groups_.end()) groups_.push_back({c_.targets[i].overrides, {}, 0});
      auto& g = groups_[group_[i]];
      g.targets.push_back(i);
      g.events = std::max(g.events, event_of(c_.targets[i].statistic));
    }
  }
  std::size_t group(std::size_t target) const { return group_[target]; }
  int runs() const { return runs_; }

  /// Permits this many further runs; at() then throws. A search that finds no descent, such as one on a jump
  /// of the misfit, ends so.
  void permit(int runs) { last_ = runs_ + runs; }
  bool exhausted() const { return runs_ >= last_; }

  const Point& at(const Vector& xi) {
    if (known_ && xi == xi_) return point_;
    if (exhausted())
      throw std::runtime_error(fmt::format("calibration: no minimum of the misfit in {} runs", runs_));
    known_ = false;
    const auto m = static_cast<Index>(c_.targets.size()), n = xi.size();
    point_ = {Vector(m), Matrix(m, n), {}, {}, {}};
    for (const auto& g : groups_) evaluate(g, xi);
    xi_ = xi;
    known_ = true;
    return point_;
  }

 private:
  struct Group {
    std::vector<std::string> overrides;
    std::vector<std::size_t> targets;
    int events = 0;  // the greatest number of a contact event
  };

  void evaluate(const Group& g, const Vector& xi) {
    const auto n = xi.size();
    auto overrides = g.overrides;
    SensitivityRequest request{
        .of = {}, .to = {}, .formulation = c_.formulation, .stop = stop_, .errors = false};
    for (const auto i : g.targets) request.of.push_back(c_.targets[i].statistic);
    // One event more: the interval after the last one.
    for (int e = 1; g.events > 0 && e <= g.events + 1; ++e)
      request.of.push_back(fmt::format("event.{}.t", e));
    for (const auto& u : c_.unknowns) request.to.push_back(u.key);
    std::ranges::copy(overrides_at(c_, xi), std::back_inserter(overrides));
    const auto scene = open_scene(study_.scene, overrides, study_.reach == Reach::anywhere);
    const auto s = sensitivities(*scene, request);
    on_run_ ? on_run_(++runs_) : void(++runs_);
    for (std::size_t k = 0; k < g.targets.size(); ++k) {
      const auto i = static_cast<Index>(g.targets[k]);
      point_.values[i] = s.quantities[k].value;
      point_.slopes.row(i) = slopes(s.quantities[k], xi);
      explain(s.quantities[k]);
    }
    const auto events = static_cast<Index>(s.quantities.size() - g.targets.size());
    point_.times.emplace_back(events);
    point_.motion.emplace_back(events, n);
    for (Index e = 0; e < events; ++e) {
      const auto& q = s.quantities[g.targets.size() + static_cast<std::size_t>(e)];
      point_.times.back()[e] = q.value;
      point_.motion.back().row(e) = slopes(q, xi);
    }
  }

  /// ∂Q/∂ξ = ∂Q/∂p dp/dξ.
  Eigen::RowVectorXd slopes(const Sensitivity& q, const Vector& xi) const {
    Eigen::RowVectorXd row(xi.size());
    for (Index j = 0; j < xi.size(); ++j) {
      const auto& u = c_.unknowns[static_cast<std::size_t>(j)];
      const double rate =
          u.logarithmic ? 0.5 * unscaled(u, xi[j]) * std::log(u.high / u.low) : 0.5 * (u.high - u.low);
      row[j] = q.derivatives[static_cast<std::size_t>(j)] * rate;
    }
    return row;
  }

  /// Keeps the reason of the first missing value or derivative.
  void explain(const Sensitivity& q) {
    if (point_.reason.empty() && !std::isfinite(q.value))
      point_.reason = fmt::format("the run does not reach {}", q.name);
    for (std::size_t j = 0; j < q.reasons.size() && point_.reason.empty(); ++j)
      if (!q.reasons[j].empty())
        point_.reason =
            fmt::format("{} has no derivative by {}: {}", q.name, c_.unknowns[j].key, q.reasons[j]);
  }

  const Study& study_;
  const Calibration& c_;
  StopToken stop_;
  std::function<void(int)> on_run_;
  std::vector<Group> groups_;
  std::vector<std::size_t> group_;  // of each target
  Vector xi_;
  Point point_;
  bool known_ = false;
  int runs_ = 0, last_ = std::numeric_limits<int>::max();
};

/// Residuals (Q − m)/σ of the used targets, and their derivatives.
struct Residuals {
  Vector r;
  Matrix J;
  bool finite = false;
  double value() const { return r.squaredNorm(); }
};

struct Problem {
  const Calibration& c;
  Model& model;
  const StopToken& stop;
  std::vector<double> deviation;
  std::vector<bool> used;

  Residuals at(const Vector& xi) const {
    const auto& p = model.at(xi);
    const auto count = std::ranges::count(used, true);
    Residuals x{Vector(count), Matrix(count, xi.size())};
    Index row = 0;
    for (std::size_t i = 0; i < used.size(); ++i) {
      if (!used[i]) continue;
      const auto k = static_cast<Index>(i);
      x.r[row] = (p.values[k] - c.targets[i].value) / deviation[i];
      x.J.row(row++) = p.slopes.row(k) / deviation[i];
    }
    x.finite = x.r.allFinite() && x.J.allFinite();
    return x;
  }
  /// C = (JᵀJ + w)⁻¹.
  static Matrix covariance(const Residuals& x) {
    const auto n = x.J.cols();
    const Matrix H = x.J.transpose() * x.J + Misfit::pull * Matrix::Identity(n, n);
    return H.llt().solve(Matrix::Identity(n, n));
  }
  /// C of the combinations of unknowns that the targets determine: those to which JᵀJ gives at least the
  /// weight w of the prior. 0 if there is none.
  static Matrix determined_covariance(const Residuals& x) {
    const Eigen::SelfAdjointEigenSolver<Matrix> H(x.J.transpose() * x.J);
    const auto& weights = H.eigenvalues();
    const Vector variances =
        (weights.array() >= Misfit::pull).select((weights.array() + Misfit::pull).inverse(), 0.0);
    return H.eigenvectors() * variances.asDiagonal() * H.eigenvectors().transpose();
  }
};

/// f(ξ) for Ipopt. A point without value or derivative shortens the step.
class LeastSquares : public Ipopt::TNLP {
 public:
  using Int = Ipopt::Index;
  using Number = Ipopt::Number;
  LeastSquares(const Problem& problem, Vector& xi, int& iterations)
      : problem_(problem), xi_(xi), iterations_(iterations) {}

  bool get_nlp_info(Int& n, Int& m, Int& nnz_jac, Int& nnz_hessian, IndexStyleEnum& style) override {
    n = static_cast<Int>(xi_.size());
    m = nnz_jac = 0;
    nnz_hessian = n * (n + 1) / 2;
    style = C_STYLE;
    return true;
  }
  bool get_bounds_info(Int n, Number* lower, Number* upper, Int, Number*, Number*) override {
    std::fill_n(lower, n, -1.0);
    std::fill_n(upper, n, 1.0);
    return true;
  }
  bool get_starting_point(Int n, bool, Number* x, bool, Number*, Number*, Int, bool, Number*) override {
    std::copy_n(xi_.data(), n, x);
    return true;
  }
  bool eval_f(Int n, const Number* x, bool, Number& value) override {
    const Vector xi = Vector::Map(x, n);
    const auto at = evaluated(xi);
    value = at.value() + Misfit::pull * xi.squaredNorm();
    return at.finite;
  }
  bool eval_grad_f(Int n, const Number* x, bool, Number* gradient) override {
    const Vector xi = Vector::Map(x, n);
    const auto at = evaluated(xi);
    last_ = xi;
    if (at.finite) Vector::Map(gradient, n) = 2 * (at.J.transpose() * at.r + Misfit::pull * xi);
    return at.finite;
  }
  bool eval_g(Int, const Number*, bool, Int, Number*) override { return true; }
  bool eval_jac_g(Int, const Number*, bool, Int, Int, Int*, Int*, Number*) override { return true; }
  bool eval_h(Int n, const Number* x, bool, Number factor, Int, const Number*, bool, Int, Int* row,
              Int* column, Number* values) override {
    Matrix H;
    if (values) {
      const auto at = evaluated(Vector::Map(x, n));
      if (!at.finite) return false;
      H = 2 * factor * (at.J.transpose() * at.J + Misfit::pull * Matrix::Identity(n, n));
    }
    for (Int i = 0, k = 0; i < n; ++i)
      for (Int j = 0; j <= i; ++j, ++k)
        if (values) {
          values[k] = H(i, j);
        } else {
          row[k] = i;
          column[k] = j;
        }
    return true;
  }
  void finalize_solution(Ipopt::SolverReturn, Int n, const Number* x, const Number*, const Number*, Int,
                         const Number*, const Number*, Number, const Ipopt::IpoptData*,
                         Ipopt::IpoptCalculatedQuantities*) override {
    xi_ = Vector::Map(x, n);
  }
  bool intermediate_callback(Ipopt::AlgorithmMode, Int iteration, Number, Number, Number, Number, Number,
                             Number, Number, Number, Int, const Ipopt::IpoptData*,
                             Ipopt::IpoptCalculatedQuantities*) override {
    iterations_ += iteration > 0;
    return !problem_.stop() && !problem_.model.exhausted() && !converged();
  }
  /// Whether the Newton step from the last point reduces f by less than 1e-6, which moves no unknown by
  /// more than 1e-3 of its standard deviation. Ipopt's own tolerances do not know this scale, and the
  /// last digits of f are those of the runs.
  bool converged() const {
    const auto at = evaluated(last_);
    if (!at.finite) return false;
    std::vector<Index> free;
    const Vector g = 2 * (at.J.transpose() * at.r + Misfit::pull * last_);
    for (Index j = 0; j < g.size(); ++j)
      if (!(std::abs(last_[j]) > 1 - 1e-6 && g[j] * last_[j] < 0)) free.push_back(j);
    const Matrix H = 2 * (at.J.transpose() * at.J + Misfit::pull * Matrix::Identity(g.size(), g.size()));
    const Vector part = g(free);
    return 0.5 * part.dot(Matrix(H(free, free)).llt().solve(part)) < 1e-6;
  }

 private:
  /// Residuals; not finite where the scene cannot be run.
  Residuals evaluated(const Vector& xi) const {
    try {
      return problem_.at(xi);
    } catch (const std::runtime_error&) {
      return {};
    }
  }

  const Problem& problem_;
  Vector& xi_;
  int& iterations_;
  Vector last_;  // the last accepted point
};

/// Moves ξ to the minimum; false if there is none from here.
bool minimise(const Problem& problem, Vector& xi, int& iterations) {
  Ipopt::SmartPtr<LeastSquares> nlp = new LeastSquares(problem, xi, iterations);
  Ipopt::SmartPtr<Ipopt::IpoptApplication> ipopt = IpoptApplicationFactory();
  const auto options = ipopt->Options();
  options->SetIntegerValue("print_level", 0);
  options->SetStringValue("sb", "yes");
  options->SetStringValue("mu_strategy", "adaptive");
  options->SetNumericValue("bound_relax_factor", 0);
  options->SetNumericValue("tol", 1e-14);  // LeastSquares::converged() ends
  options->SetIntegerValue("max_iter", 60);
  if (ipopt->Initialize("") != Ipopt::Solve_Succeeded) return false;
  ipopt->OptimizeTNLP(Ipopt::SmartPtr<Ipopt::TNLP>(Ipopt::GetRawPtr(nlp)));
  if (problem.stop()) throw Interrupted();
  return nlp->converged();
}

/// Whether the unknowns determine the time of an event to a quarter of the intervals to its neighbours.
bool within_horizon(const Vector& times, const Matrix& motion, int event, const Matrix& covariance) {
  const Index e = event - 1;
  const double before = e > 0 ? times[e] - times[e - 1] : times[e];
  const double after = times[e + 1] - times[e];  // NaN: the last event of the run
  const double gap = std::isfinite(after) ? std::min(before, after) : before;
  const double deviation = std::sqrt((motion.row(e) * covariance * motion.row(e).transpose()).value());
  return deviation <= 0.25 * gap;
}

/// Fits from one start.
QuantityFit fit_from(Vector xi, Problem problem) {
  const auto& c = problem.c;
  auto& model = problem.model;
  QuantityFit fit;
  std::map<int, std::vector<std::size_t>> stages;  // targets by the number of their event
  for (std::size_t i = 0; i < c.targets.size(); ++i) {
    const int e = event_of(c.targets[i].statistic);
    // Other quantities depend on the whole run.
    stages[e > 0 ? e : std::numeric_limits<int>::max()].push_back(i);
  }
  problem.used.assign(c.targets.size(), false);
  std::size_t count = 0;
  for (auto stage = stages.begin(); stage != stages.end(); ++stage) {
    const int e = stage->first;
    // Unknowns that no earlier target determines put no event beyond the horizon: they may be determined by
    // this one, as the restitution by the second impact.
    const Matrix covariance = count >= c.unknowns.size() ? Problem::determined_covariance(problem.at(xi))
                                                         : Matrix::Zero(xi.size(), xi.size());
    const bool determined = !covariance.isZero(0);
    if (determined && e < std::numeric_limits<int>::max()) {
      const auto& p = model.at(xi);
      const bool known = std::ranges::all_of(stage->second, [&](std::size_t i) {
        const auto g = model.group(i);
        return within_horizon(p.times[g], p.motion[g], e, covariance);
      });
      if (!known) {
        fit.beyond = true;
        break;
      }
    }
    const auto before = problem.used;
    for (const auto i : stage->second) problem.used[i] = true;
    count += stage->second.size();
    if (count < c.unknowns.size() && std::next(stage) != stages.end()) continue;
    if (!problem.at(xi).finite) {
      if (!determined) throw std::runtime_error("calibration: " + model.at(xi).reason);
      problem.used = before;
      fit.beyond = true;
      break;
    }
    if (!minimise(problem, xi, fit.iterations))
      throw std::runtime_error("calibration: Ipopt found no minimum of the misfit");
    if (e < std::numeric_limits<int>::max()) fit.horizon = e;
  }
  const auto found = problem.at(xi);
  const auto covariance = Problem::covariance(found);
  const auto& p = model.at(xi);
  for (std::size_t i = 0; i < c.targets.size(); ++i) {
    const auto row = p.slopes.row(static_cast<Index>(i));
    fit.targets.push_back({p.values[static_cast<Index>(i)], problem.deviation[i],
                           std::sqrt((row * covariance * row.transpose()).value()), problem.used[i]});
  }
  fit.xi = xi;
  fit.squares = found.value();
  fit.degrees = static_cast<int>(found.r.size() - xi.size());
  const auto degrees = std::max(fit.degrees, 1);
  fit.rejected = !found.finite || fit.squares > chi_squared_quantile(degrees, 0.99);
  const Vector sd = covariance.diagonal().cwiseSqrt();
  fit.correlation = sd.cwiseInverse().asDiagonal() * covariance * sd.cwiseInverse().asDiagonal();
  const double wide = normal_quantile(0.975);
  for (Index j = 0; j < xi.size(); ++j) {
    const auto& u = c.unknowns[static_cast<std::size_t>(j)];
    const double low = xi[j] - wide * sd[j], high = xi[j] + wide * sd[j];
    Estimate e{unscaled(u, xi[j]), NAN, NAN, low <= -1, high >= 1};
    if (!fit.rejected) {
      e.low = unscaled(u, std::max(low, -1.0));
      e.high = unscaled(u, std::min(high, 1.0));
    }
    fit.unknowns.push_back(e);
  }
  return fit;
}

}  // namespace

bool fits_quantities(const Calibration& calibration) {
  return !calibration.targets.empty() && calibration.targets.front().is_quantity();
}

QuantityFit fit_quantities(const Study& study, const StopToken& stop,
                           const std::function<void(int)>& on_run) {
  const auto& c = *study.calibration;
  const auto n = static_cast<int>(c.unknowns.size());
  Model model(study, stop, on_run);
  Problem problem{c, model, stop, {}, {}};
  for (const auto& t : c.targets)
    problem.deviation.push_back(t.deviation > 0 ? t.deviation : t.tolerance * std::abs(t.value));
  // The centre of the ranges first; other starts only if its minimum is not consistent.
  constexpr int starts = 8;
  constexpr int runs_each = 100;  // about ten times what a start needs
  const auto more = space_filling(n, starts);
  QuantityFit best;
  std::string reason;
  bool any = false;
  for (int k = 0; k <= starts; ++k) {
    const Vector start = k == 0 ? Vector(Vector::Zero(n)) : Vector(more.row(k - 1).transpose());
    try {
      model.permit(runs_each);
      auto fit = fit_from(start, problem);
      // A fit that reaches further is better; of equal reach, the one with less misfit.
      const auto reach = [](const QuantityFit& f) {
        return std::ranges::count(f.targets, true, &FittedQuantity::used);
      };
      const bool better =
          !any || std::pair(!fit.rejected, reach(fit)) > std::pair(!best.rejected, reach(best)) ||
          (fit.rejected == best.rejected && reach(fit) == reach(best) && fit.squares < best.squares);
      const int iterations = best.iterations + fit.iterations;
      if (better) best = std::move(fit);
      best.iterations = iterations;
      any = true;
    } catch (const Interrupted&) {
      throw;
    } catch (const std::runtime_error& e) {
      if (k == 0 && model.runs() == 0)  // the study is wrong
        throw SceneError(fmt::format("{}: [calibrate]: {}", study.file.string(), e.what()));
      if (reason.empty()) reason = e.what();
    }
    if (any && !best.rejected) break;
  }
  if (!any) throw std::runtime_error(reason);
  best.runs = model.runs();
  return best;
}

}  // namespace freeplay
