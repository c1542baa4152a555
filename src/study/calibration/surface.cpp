#include "study/calibration/surface.hpp"

#include <algorithm>
#include <array>
#include <boost/random/sobol.hpp>
#include <cmath>
#include <stdexcept>

namespace freeplay {
namespace {

/// The basis 1, ξ_i, ξ_i ξ_j (i ≤ j).
Eigen::VectorXd basis(const Eigen::VectorXd& xi) {
  const auto n = xi.size();
  Eigen::VectorXd b(ResponseSurface::coefficients(static_cast<int>(n)));
  Eigen::Index k = 0;
  b[k++] = 1;
  for (Eigen::Index i = 0; i < n; ++i) b[k++] = xi[i];
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = i; j < n; ++j) b[k++] = xi[i] * xi[j];
  return b;
}

/// ∂b/∂ξ, one column for each unknown.
Eigen::MatrixXd basis_gradient(const Eigen::VectorXd& xi) {
  const auto n = xi.size();
  Eigen::MatrixXd g = Eigen::MatrixXd::Zero(ResponseSurface::coefficients(static_cast<int>(n)), n);
  Eigen::Index k = 1;
  for (Eigen::Index i = 0; i < n; ++i) g(k++, i) = 1;
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = i; j < n; ++j, ++k) {
      g(k, i) += xi[j];
      g(k, j) += xi[i];
    }
  return g;
}

/// κ(d) of the process, from d².
double kernel(double square, bool rough) {
  if (!rough) return std::exp(-0.5 * square);
  const double d = std::sqrt(3 * square);
  return (1 + d) * std::exp(-d);
}

/// Matrix of κ(d) for all pairs of rows.
Eigen::MatrixXd correlation(const Eigen::MatrixXd& points, const Eigen::VectorXd& lengths, bool rough) {
  const Eigen::MatrixXd scaled = points * lengths.cwiseInverse().asDiagonal();
  const auto m = points.rows();
  Eigen::MatrixXd R(m, m);
  for (Eigen::Index i = 0; i < m; ++i)
    for (Eigen::Index j = 0; j <= i; ++j)
      R(i, j) = R(j, i) = kernel((scaled.row(i) - scaled.row(j)).squaredNorm(), rough);
  return R;
}

/// The warp of one coordinate in [−1, 1] by a, and its derivative.
struct Warped {
  double value, slope;
};
Warped warped(double x, double a) {
  if (a == 0) return {x, 1};
  const double b = std::abs(a), u = 0.5 * (a > 0 ? x + 1 : 1 - x), scale = std::log1p(b);
  const double value = 2 * std::log1p(b * u) / scale - 1;
  return {a > 0 ? value : -value, b / (scale * (1 + b * u))};
}
Eigen::VectorXd warped(const Eigen::VectorXd& xi, const Eigen::VectorXd& a) {
  Eigen::VectorXd w(xi.size());
  for (Eigen::Index j = 0; j < xi.size(); ++j) w[j] = warped(xi[j], a[j]).value;
  return w;
}
Eigen::MatrixXd rows_warped(const Eigen::MatrixXd& points, const Eigen::VectorXd& a) {
  Eigen::MatrixXd w(points.rows(), points.cols());
  for (Eigen::Index i = 0; i < points.rows(); ++i)
    w.row(i) = warped(points.row(i).transpose(), a).transpose();
  return w;
}
Eigen::MatrixXd rows_of_basis(const Eigen::MatrixXd& points) {
  Eigen::MatrixXd B(points.rows(), ResponseSurface::coefficients(static_cast<int>(points.cols())));
  for (Eigen::Index i = 0; i < points.rows(); ++i) B.row(i) = basis(points.row(i).transpose()).transpose();
  return B;
}

constexpr std::array warps_tried{0.0, 4.0, 20.0, -4.0, -20.0};
constexpr std::array ratios{0.0, 0.03, 0.1, 0.3, 1.0, 3.0, 10.0, 30.0, 100.0, 1e3, 1e4, 1e5, 1e6};
/// Greatest ratio m ρ/min c, which bounds the condition of K. Beyond, rounding errors of the kriging variance
/// exceed the variance itself.
constexpr double most_condition = 1e9;
constexpr std::array lengths_tried{0.06, 0.12, 0.18, 0.25, 0.35, 0.5, 0.7, 1.0, 1.4, 2.0, 2.8};

}  // namespace

/// Factors and coefficients for given points, noise, ρ and ℓ.
struct ResponseSurface::Kriging {
  Eigen::LLT<Eigen::MatrixXd> K, trend;
  Eigen::MatrixXd solved;                   // K⁻¹B
  Eigen::VectorXd beta, residual, weights;  // weights: K⁻¹(y − Bβ)
  double squares = 0, log_likelihood = 0;   // squares: yᵀQy

  Kriging(const Eigen::MatrixXd& R, double ratio, const Eigen::VectorXd& c, const Eigen::MatrixXd& B,
          const Eigen::VectorXd& y, double least, double floor) {
    Eigen::MatrixXd sum = ratio * R;
    sum.diagonal() += c;
    K.compute(sum);
    solved = K.solve(B);
    trend.compute(B.transpose() * solved);
    beta = trend.solve(solved.transpose() * y);
    residual = y - B * beta;
    weights = K.solve(residual);
    squares = std::max(0.0, residual.dot(weights));
    const auto freedom = static_cast<double>(B.rows() - B.cols());
    const auto log_determinant = [](const Eigen::LLT<Eigen::MatrixXd>& l) {
      return 2 * l.matrixLLT().diagonal().array().log().sum();
    };
    const Eigen::LLT<Eigen::MatrixXd> metric(B.transpose() * B);
    // σ² is at least the noise between starts. With a smaller one ρ would be too great, and ρσ² with it.
    const double noise = std::max(squares / freedom + least, floor);
    log_likelihood = -0.5 * (freedom * (std::log(noise) - 1) + squares / noise + log_determinant(K) +
                             log_determinant(trend) - log_determinant(metric));
  }
};

ResponseSurface::ResponseSurface(const Eigen::MatrixXd& points, const Eigen::VectorXd& outcomes,
                                 const Eigen::VectorXd& noise, double least_noise)
    : points_(points) {
  const auto m = points.rows();
  const auto n = points.cols();
  const int p = coefficients(static_cast<int>(n));
  if (m < p + 2) throw std::invalid_argument("too few points for a quadratic surface");
  const Eigen::VectorXd c = noise.size() == m ? noise : Eigen::VectorXd::Ones(m);
  Eigen::MatrixXd B = rows_of_basis(points);
  freedom_ = static_cast<double>(m - p);
  spread_ = std::sqrt((outcomes.array() - outcomes.mean()).square().sum() / static_cast<double>(m - 1));
  // Rounding of the outcomes, below which the likelihood has no meaning.
  const double least = std::pow(1e-12 * (outcomes.cwiseAbs().maxCoeff() + 1e-300), 2);

  const double floor = std::max(least_noise, 0.0);
  lengths_ = Eigen::VectorXd::Ones(n);
  warps_ = Eigen::VectorXd::Zero(n);
  Eigen::MatrixXd R = correlation(points_, lengths_, rough_);
  const auto prior = [](const Eigen::VectorXd& lengths, const Eigen::VectorXd& warps) {
    return -0.5 * ((lengths.array().log() / std::log(2.0)).square().sum() +
                   ((1 + warps.array().abs()).log() / std::log(5.0)).square().sum());
  };
  const auto worth = [&](const Eigen::MatrixXd& of, const Eigen::MatrixXd& trend,
                         const Eigen::VectorXd& lengths, const Eigen::VectorXd& warps,
                         double ratio) -> double {
    if (static_cast<double>(m) * ratio > most_condition * c.minCoeff()) return -INFINITY;
    const Kriging k(of, ratio, c, trend, outcomes, least, floor);
    return k.K.info() == Eigen::Success && std::isfinite(k.log_likelihood)
               ? k.log_likelihood + prior(lengths, warps)
               : -INFINITY;
  };
  double best = -INFINITY;
  const auto try_ratios = [&] {
    for (const double r : ratios)
      if (const double w = worth(R, B, lengths_, warps_, r); w > best) best = w, ratio_ = r;
  };
  try_ratios();
  const auto try_with = [&](const Eigen::VectorXd& lengths, bool rough, std::initializer_list<double> list) {
    const auto of = correlation(points_, lengths, rough);
    for (const double r : list)
      if (const double w = worth(of, B, lengths, warps_, r); w > best) {
        best = w;
        ratio_ = r;
        lengths_ = lengths;
        rough_ = rough;
      }
  };
  // Equal lengths first, from which the single ones are found.
  for (const bool rough : {false, true})
    for (const double l : lengths_tried)
      try_with(Eigen::VectorXd::Constant(n, l), rough, {1.0, 30.0, 1e3, 1e5});
  R = correlation(points_, lengths_, rough_);
  // If the quadratic trend is exact, there is no process.
  const bool exact = Kriging(R, 0, c, B, outcomes, least, floor).squares <= freedom_ * least;
  if (exact) ratio_ = 0;
  const auto try_lengths = [&](bool rough) {
    for (Eigen::Index j = 0; j < n; ++j) {
      Eigen::VectorXd lengths = lengths_;
      for (const double l : lengths_tried) {
        lengths[j] = l;
        const double from = ratio_ > 0 ? ratio_ : 1;
        try_with(lengths, rough, {from, 3 * from});
      }
    }
    R = correlation(points_, lengths_, rough_);
    try_ratios();
  };
  for (int cycle = 0; cycle < 2 && !exact; ++cycle) {
    for (Eigen::Index j = 0; j < n; ++j) {
      Eigen::VectorXd warps = warps_;
      for (const double a : warps_tried) {
        warps[j] = a;
        const auto at = rows_warped(points, warps);
        const auto of = correlation(at, lengths_, rough_);
        const auto trend = rows_of_basis(at);
        for (const double r : {ratio_, ratio_ > 0 ? 0.3 * ratio_ : 1.0, ratio_ > 0 ? 3 * ratio_ : 10.0})
          if (const double w = worth(of, trend, lengths_, warps, r); w > best) {
            best = w;
            ratio_ = r;
            warps_ = warps;
          }
      }
    }
    points_ = rows_warped(points, warps_);
    B = rows_of_basis(points_);
    for (const bool rough : {rough_, !rough_}) try_lengths(rough);
  }

  const Kriging k(R, ratio_, c, B, outcomes, least, floor);
  trend_ = k.beta;
  weights_ = k.weights;
  solved_ = k.solved;
  factors_ = k.K;
  const Eigen::MatrixXd inverse = k.K.solve(Eigen::MatrixXd::Identity(m, m));
  trend_covariance_ = k.trend.solve(Eigen::MatrixXd::Identity(p, p));
  // Qy = K⁻¹(y − Bβ), and the diagonal of Q. With few degrees of freedom the likelihood's σ² may be
  // too small by chance; it must not be less than the leave-one-out estimate Σ (Qy)_p²/Q_pp/m.
  double press = 0, left_out = 0;
  surprise_.resize(m);
  for (Eigen::Index i = 0; i < m; ++i) {
    const double q = inverse(i, i) - solved_.row(i) * trend_covariance_ * solved_.row(i).transpose();
    press += std::pow(weights_[i] / q, 2);
    surprise_[i] = weights_[i] * weights_[i] / q;
    left_out += weights_[i] * weights_[i] / q / static_cast<double>(m);
  }
  noise_ = std::max({k.squares / freedom_, left_out, least_noise});
  error_ = std::sqrt(press / static_cast<double>(m));
  if (noise_ > 0) surprise_ /= noise_;
  if (least_noise >= 0) roughness_ = std::max(0.0, noise_ - least_noise);
}

Eigen::VectorXd ResponseSurface::squares(const Eigen::VectorXd& warped) const {
  return ((points_.rowwise() - warped.transpose()) * lengths_.cwiseInverse().asDiagonal())
      .rowwise()
      .squaredNorm();
}
Eigen::VectorXd ResponseSurface::correlations(const Eigen::VectorXd& warped) const {
  return squares(warped).unaryExpr([this](double x) { return kernel(x, rough_); });
}

double ResponseSurface::operator()(const Eigen::VectorXd& xi) const {
  const auto at = warped(xi, warps_);
  const double trend = basis(at).dot(trend_);
  return ratio_ > 0 ? trend + ratio_ * correlations(at).dot(weights_) : trend;
}

Eigen::VectorXd ResponseSurface::gradient(const Eigen::VectorXd& xi) const {
  const auto at = warped(xi, warps_);
  Eigen::VectorXd g = basis_gradient(at).transpose() * trend_;
  if (ratio_ > 0) {
    // κ' = −κ d for the normal kernel and −3 d exp(−√3 d) for Matérn's.
    const Eigen::VectorXd fall =
        rough_ ? squares(at).unaryExpr([](double x) { return 3 * std::exp(-std::sqrt(3 * x)); }).eval()
               : correlations(at);
    const Eigen::VectorXd w = ratio_ * fall.cwiseProduct(weights_);
    for (Eigen::Index j = 0; j < at.size(); ++j)
      g[j] += w.dot(points_.col(j) - Eigen::VectorXd::Constant(points_.rows(), at[j])) /
              (lengths_[j] * lengths_[j]);
  }
  for (Eigen::Index j = 0; j < at.size(); ++j) g[j] *= warped(xi[j], warps_[j]).slope;
  return g;
}

double ResponseSurface::surprise_near(const Eigen::VectorXd& warped) const {
  const Eigen::VectorXd near = (-2 * squares(warped)).array().exp();
  return std::min(25.0, (1 + near.dot(surprise_)) / (1 + near.sum()));
}

double ResponseSurface::reducible(const Eigen::VectorXd& xi) const {
  const auto at = warped(xi, warps_);
  Eigen::VectorXd u = basis(at);
  double process = 0;
  if (ratio_ > 0) {
    const Eigen::VectorXd r = ratio_ * correlations(at);
    process = ratio_ - factors_.matrixL().solve(r).squaredNorm();
    u -= solved_.transpose() * r;
  }
  return noise_ * std::max(1.0, surprise_near(at)) * std::max(0.0, process + u.dot(trend_covariance_ * u));
}

double ResponseSurface::roughness(const Eigen::VectorXd& xi) const {
  return roughness_ > 0 ? roughness_ * surprise_near(warped(xi, warps_)) : 0;
}

Eigen::MatrixXd space_filling(int unknowns, int count) {
  boost::random::sobol engine(static_cast<std::size_t>(unknowns));
  Eigen::MatrixXd points(count, unknowns);
  const double range = static_cast<double>(boost::random::sobol::max());
  for (int i = 0; i < count; ++i)
    for (int j = 0; j < unknowns; ++j) points(i, j) = 2 * (static_cast<double>(engine()) / range) - 1;
  return points;
}

}  // namespace freeplay
