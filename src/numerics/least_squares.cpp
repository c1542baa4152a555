#include "numerics/least_squares.hpp"

#include <algorithm>
#include <vector>

#include "numerics/dense.hpp"

namespace freeplay {

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
