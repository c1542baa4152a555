// The bounded least-squares problem of calibration, by Ipopt.
#include <coin/IpIpoptApplication.hpp>
#include <coin/IpTNLP.hpp>

#include <algorithm>
#include <boost/math/distributions/normal.hpp>
#include <cmath>
#include <random>
#include <stdexcept>

#include "study/calibrate.hpp"

namespace freeplay {
namespace {

constexpr double pull = 0.1;

struct Objective {
  const std::vector<ResponseSurface>& surfaces;
  const std::vector<double>& log_measured;
  std::vector<double> weight;  // 1/s², 0 for a target left out

  double value(const Eigen::VectorXd& xi) const {
    double f = pull * xi.squaredNorm();
    for (std::size_t i = 0; i < surfaces.size(); ++i) {
      const double r = surfaces[i](xi) - log_measured[i];
      f += weight[i] * r * r;
    }
    return f;
  }
  Eigen::VectorXd gradient(const Eigen::VectorXd& xi) const {
    Eigen::VectorXd g = 2 * pull * xi;
    for (std::size_t i = 0; i < surfaces.size(); ++i)
      g += 2 * weight[i] * (surfaces[i](xi) - log_measured[i]) * surfaces[i].gradient(xi);
    return g;
  }
  Eigen::MatrixXd hessian(const Eigen::VectorXd& xi, bool gauss_newton) const {
    Eigen::MatrixXd H = 2 * pull * Eigen::MatrixXd::Identity(xi.size(), xi.size());
    for (std::size_t i = 0; i < surfaces.size(); ++i) {
      const Eigen::VectorXd g = surfaces[i].gradient(xi);
      H += 2 * weight[i] * g * g.transpose();
      if (!gauss_newton) H += 2 * weight[i] * (surfaces[i](xi) - log_measured[i]) * surfaces[i].hessian();
    }
    return H;
  }
};

class Program : public Ipopt::TNLP {
 public:
  using Index = Ipopt::Index;
  using Number = Ipopt::Number;
  Program(const Objective& objective, const Eigen::VectorXd& start) : f_(objective), xi(start) {}

  bool get_nlp_info(Index& n, Index& m, Index& jacobian, Index& hessian, IndexStyleEnum& style) override {
    n = static_cast<Index>(xi.size());
    m = jacobian = 0;
    hessian = n * (n + 1) / 2;
    style = C_STYLE;
    return true;
  }
  bool get_bounds_info(Index n, Number* low, Number* high, Index, Number*, Number*) override {
    std::fill(low, low + n, -1.0);
    std::fill(high, high + n, 1.0);
    return true;
  }
  bool get_starting_point(Index n, bool, Number* x, bool, Number*, Number*, Index, bool, Number*) override {
    std::copy(xi.data(), xi.data() + n, x);
    return true;
  }
  bool eval_f(Index n, const Number* x, bool, Number& value) override {
    value = f_.value(Eigen::Map<const Eigen::VectorXd>(x, n));
    return true;
  }
  bool eval_grad_f(Index n, const Number* x, bool, Number* g) override {
    Eigen::Map<Eigen::VectorXd>(g, n) = f_.gradient(Eigen::Map<const Eigen::VectorXd>(x, n));
    return true;
  }
  bool eval_g(Index, const Number*, bool, Index, Number*) override { return true; }
  bool eval_jac_g(Index, const Number*, bool, Index, Index, Index*, Index*, Number*) override { return true; }
  bool eval_h(Index n, const Number* x, bool, Number factor, Index, const Number*, bool, Index, Index* row,
              Index* column, Number* values) override {
    Eigen::MatrixXd H;
    if (values) H = factor * f_.hessian(Eigen::Map<const Eigen::VectorXd>(x, n), false);
    for (Index i = 0, k = 0; i < n; ++i)
      for (Index j = 0; j <= i; ++j, ++k) {
        if (values)
          values[k] = H(i, j);
        else
          row[k] = i, column[k] = j;
      }
    return true;
  }
  void finalize_solution(Ipopt::SolverReturn, Index n, const Number* x, const Number*, const Number*, Index,
                         const Number*, const Number*, Number value, const Ipopt::IpoptData*,
                         Ipopt::IpoptCalculatedQuantities*) override {
    xi = Eigen::Map<const Eigen::VectorXd>(x, n);
    objective = value;
  }

 private:
  const Objective& f_;

 public:
  Eigen::VectorXd xi;
  double objective = INFINITY;
};

/// Points of the normal distribution of this mean and covariance that lie within [−1, 1]ⁿ, the same always.
Eigen::MatrixXd drawn(const Eigen::VectorXd& mean, const Eigen::MatrixXd& covariance) {
  const Eigen::MatrixXd L = covariance.llt().matrixL();
  Eigen::MatrixXd points(draws, mean.size());
  std::mt19937_64 generator(1);
  const auto normal = [&] {  // not std::normal_distribution, which is another one in every library
    return boost::math::quantile(boost::math::normal(),
                                 (static_cast<double>(generator() >> 11) + 0.5) * 0x1p-53);
  };
  for (int k = 0; k < draws; ++k) {
    Eigen::VectorXd xi;
    for (int tries = 0; tries < 10000; ++tries) {
      xi = mean + L * Eigen::VectorXd::NullaryExpr(mean.size(), normal);
      if (xi.lpNorm<Eigen::Infinity>() <= 1) break;
    }
    points.row(k) = xi.cwiseMax(-1).cwiseMin(1).transpose();
  }
  return points;
}

}  // namespace

double unscaled(const Unknown& u, double xi) {
  const double s = 0.5 * (xi + 1);
  return u.logarithmic ? u.low * std::pow(u.high / u.low, s) : u.low + s * (u.high - u.low);
}

Fit fit(const std::vector<ResponseSurface>& surfaces, const std::vector<double>& log_measured,
        const std::vector<double>& tolerance, const std::vector<bool>& used,
        const std::vector<Unknown>& unknowns) {
  const auto n = static_cast<int>(unknowns.size());
  Objective objective{surfaces, log_measured, {}};
  std::vector<double> sigma;
  for (std::size_t i = 0; i < surfaces.size(); ++i) {
    sigma.push_back(std::hypot(tolerance[i], surfaces[i].error()));
    objective.weight.push_back(used[i] ? 1 / (sigma[i] * sigma[i]) : 0);
  }
  Fit best;
  best.used = used;
  best.objective = INFINITY;
  // A quadratic surface may bend f to several minima: start from the middle and from points of Sobol's
  // sequence.
  Eigen::MatrixXd starts = 0.9 * space_filling(n, 16);
  starts.row(0).setZero();
  for (Eigen::Index s = 0; s < starts.rows(); ++s) {
    Ipopt::SmartPtr<Program> program = new Program(objective, starts.row(s).transpose());
    Ipopt::SmartPtr<Ipopt::IpoptApplication> ipopt = IpoptApplicationFactory();
    ipopt->Options()->SetIntegerValue("print_level", 0);
    ipopt->Options()->SetStringValue("sb", "yes");
    ipopt->Options()->SetNumericValue("tol", 1e-9);
    if (ipopt->Initialize("") != Ipopt::Solve_Succeeded) continue;
    const auto status = ipopt->OptimizeTNLP(program);
    if (status != Ipopt::Solve_Succeeded && status != Ipopt::Solved_To_Acceptable_Level) continue;
    if (program->objective < best.objective) {
      best.objective = program->objective;
      best.xi = program->xi;
    }
  }
  if (!std::isfinite(best.objective))
    throw std::runtime_error(
        "calibration: the fit found no minimum; widen the ranges of the unknowns, or give more points");

  const Eigen::MatrixXd covariance = (0.5 * objective.hessian(best.xi, true)).inverse();
  for (int j = 0; j < n; ++j) {
    const double half = 1.96 * std::sqrt(covariance(j, j));
    const auto at = [&](double xi) { return unscaled(unknowns[j], std::clamp(xi, -1.0, 1.0)); };
    best.unknowns.push_back({at(best.xi[j]), at(best.xi[j] - half), at(best.xi[j] + half)});
  }
  best.draws = drawn(best.xi, covariance);
  for (std::size_t i = 0; i < surfaces.size(); ++i) {
    const Eigen::VectorXd g = surfaces[i].gradient(best.xi);
    const double y = surfaces[i](best.xi);
    const double half = 1.96 * std::sqrt(g.dot(covariance * g) + surfaces[i].error() * surfaces[i].error());
    best.on_surface.push_back({std::exp(y), std::exp(y - half), std::exp(y + half)});
  }
  return best;
}

}  // namespace freeplay
