#include "numerics/complementarity.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "numerics/dense.hpp"

namespace freeplay {

double lcp_residual(int n, const double* A, int stride, const double* b, const double* z) {
  double worst = 0, scale = 0;
  for (int i = 0; i < n; ++i) {
    double w = b[i];
    for (int j = 0; j < n; ++j) w += A[i + j * stride] * z[j];
    worst = std::max(worst, std::abs(std::min(w, z[i])));
    scale = std::max(scale, std::abs(b[i]));
  }
  return scale > 0 ? worst / scale : worst;
}

Lemke::Lemke(int max_size) : tableau_(max_size, 2 * max_size + 2), basis_(max_size) {}

void Lemke::pivot(int n, int row, int column) {
  const int width = 2 * n + 2;
  const double p = 1 / tableau_(row, column);
  for (int j = 0; j < width; ++j) tableau_(row, j) *= p;
  tableau_(row, column) = 1;
  for (int i = 0; i < n; ++i) {
    const double factor = tableau_(i, column);
    if (i == row || factor == 0) continue;
    for (int j = 0; j < width; ++j) tableau_(i, j) -= factor * tableau_(row, j);
    tableau_(i, column) = 0;
  }
  basis_[row] = column;
}

/// The row with the lexicographically least (b, w-columns)/entry among those with a positive entry;
/// −1 if there is none.
int Lemke::leaving_row(int n, int column) const {
  const double least = 1e-12 * tableau_.col(column).head(n).cwiseAbs().maxCoeff();
  const int rhs = 2 * n + 1;
  int best = -1;
  for (int i = 0; i < n; ++i) {
    if (!(tableau_(i, column) > least)) continue;
    if (best < 0) {
      best = i;
      continue;
    }
    const double pi = tableau_(i, column), pb = tableau_(best, column);
    double difference = tableau_(i, rhs) / pi - tableau_(best, rhs) / pb;
    const double tie = 1e-13 * (std::abs(tableau_(i, rhs) / pi) + std::abs(tableau_(best, rhs) / pb)) +
                       1e-14 * scale_ / std::min(pi, pb);  // rounding of a degenerate zero
    if (std::abs(difference) <= tie) {
      // z0 leaves the basis whenever possible: the problem is then solved.
      if (basis_[i] == 2 * n) {
        best = i;
        continue;
      }
      if (basis_[best] == 2 * n) continue;
      difference = 0;
      for (int j = 0; j < n && difference == 0; ++j)
        difference = tableau_(i, j) / pi - tableau_(best, j) / pb;
    }
    if (difference < 0) best = i;
  }
  return best;
}

LcpResult Lemke::solve(int n, const double* A, int stride, const double* b, double* z) {
  LcpResult result;
  std::fill(z, z + n, 0.0);
  const int z0 = 2 * n, rhs = 2 * n + 1;
  int worst = 0;
  for (int i = 1; i < n; ++i)
    if (b[i] <= b[worst]) worst = i;  // last of equals: lexicographically least (b_i, e_i)
  if (n == 0 || b[worst] >= 0) return result;

  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) {
      tableau_(i, j) = i == j ? 1 : 0;
      tableau_(i, n + j) = -A[i + j * stride];
    }
    tableau_(i, z0) = -1;
    tableau_(i, rhs) = b[i];
    basis_[i] = i;
  }
  scale_ = -b[worst];
  pivot(n, worst, z0);
  result.pivots = 1;
  int entering = n + worst;
  const int most = 50 * n + 100;
  for (;; ++result.pivots) {
    if (result.pivots > most) {
      result.status = LcpResult::Status::pivots_exhausted;
      break;
    }
    const int row = leaving_row(n, entering);
    if (row < 0) {
      result.status = LcpResult::Status::ray;
      break;
    }
    const int leaving = basis_[row];
    pivot(n, row, entering);
    if (leaving == z0) break;
    entering = leaving < n ? leaving + n : leaving - n;
  }
  for (int i = 0; i < n; ++i)
    if (basis_[i] >= n && basis_[i] < z0) z[basis_[i] - n] = std::max(0.0, tableau_(i, rhs));
  result.residual = lcp_residual(n, A, stride, b, z);
  // In a degenerate problem the artificial variable may remain basic at zero. z is then a solution,
  // and its residual shows it.
  if (result.status == LcpResult::Status::ray && result.residual < 1e-12)
    result.status = LcpResult::Status::solved;
  return result;
}

void nonnegative_least_squares(const Eigen::MatrixXd& K, const Eigen::VectorXd& y, Eigen::VectorXd& x,
                               double none) {
  const auto n = K.cols();
  x.setZero(n);
  std::vector<Eigen::Index> in;
  Eigen::VectorXd gradient;
  for (Eigen::Index pass = 0; pass < 3 * n + 3; ++pass) {
    gradient = K.transpose() * (y - K * x);
    Eigen::Index best = -1;
    for (Eigen::Index j = 0; j < n; ++j)
      if (std::ranges::find(in, j) == in.end() && gradient[j] > none &&
          (best < 0 || gradient[j] > gradient[best]))
        best = j;
    if (best < 0) return;
    in.push_back(best);
    for (Eigen::Index inner = 0; inner <= n; ++inner) {
      const Eigen::VectorXd s = MinimumNorm(K(Eigen::all, in)).solve(y);
      double step = 1;
      for (std::size_t i = 0; i < in.size(); ++i)
        if (s[static_cast<Eigen::Index>(i)] < 0) {
          const double from = x[in[i]], to = s[static_cast<Eigen::Index>(i)];
          step = std::min(step, from > 0 ? from / (from - to) : 0);
        }
      for (std::size_t i = 0; i < in.size(); ++i)
        x[in[i]] += step * (s[static_cast<Eigen::Index>(i)] - x[in[i]]);
      if (step == 1) break;
      const auto before = in.size();
      std::erase_if(in, [&](Eigen::Index j) {
        if (x[j] > 1e-15 * x.maxCoeff()) return false;
        x[j] = 0;
        return true;
      });
      if (in.size() == before || in.empty()) break;
    }
  }
}

/// With E = [Gᵀ; hᵀ] and f = (0, …, 0, 1), the residual r = E y − f of the least squares over y ≥ 0
/// gives x_j = −r_j/r_{n+1}. r = 0 if no x is admissible. The last entry of r is −1/(1 + |x|²).
bool least_distance(const Eigen::MatrixXd& G, const Eigen::VectorXd& h, double slack, Eigen::VectorXd& x) {
  const auto n = G.cols(), m = G.rows();
  x.setZero(n);
  if (m == 0 || h.maxCoeff() <= 0) return true;
  Eigen::MatrixXd E(n + 1, m);
  E << G.transpose(), (h.array() - slack).matrix().transpose();
  Eigen::VectorXd f = Eigen::VectorXd::Zero(n + 1), y;
  f[n] = 1;
  nonnegative_least_squares(E, f, y, 1e-14);
  const Eigen::VectorXd r = E * y - f;
  if (!(r[n] < -1e-9)) return false;
  // Least length on the intersection of the active constraints, which are thus satisfied exactly.
  std::vector<Eigen::Index> held;
  for (Eigen::Index i = 0; i < m; ++i)
    if (y[i] > 0) held.push_back(i);
  const Eigen::VectorXd near = -r.head(n) / r[n];
  if (held.empty()) return true;
  x = MinimumNorm(G(held, Eigen::all)).solve(h(held));
  const auto short_by = [&](const Eigen::VectorXd& at) { return (h - G * at).maxCoeff(); };
  if (short_by(x) > std::max(slack, short_by(near))) x = near;
  return true;
}

}  // namespace freeplay
