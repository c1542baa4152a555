#include "numerics/lcp.hpp"

#include <algorithm>
#include <cmath>

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

}  // namespace freeplay
