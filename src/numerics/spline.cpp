#include "numerics/spline.hpp"

#include <cstddef>

namespace freeplay {
namespace {

/// Thomas algorithm for a_i x_{i−1} + b_i x_i + c_i x_{i+1} = r_i; the matrix is diagonally
/// dominant.
std::vector<double> tridiagonal(const std::vector<double>& a, std::vector<double> b,
                                const std::vector<double>& c, std::vector<double> r) {
  const std::size_t n = b.size();
  for (std::size_t i = 1; i < n; ++i) {
    const double w = a[i] / b[i - 1];
    b[i] -= w * c[i - 1];
    r[i] -= w * r[i - 1];
  }
  r[n - 1] /= b[n - 1];
  for (std::size_t i = n - 1; i-- > 0;) r[i] = (r[i] - c[i] * r[i + 1]) / b[i];
  return r;
}

/// The tridiagonal system with corners c_n x_1 in the last row and a_1 x_n in the first, by the
/// Sherman–Morrison formula.
std::vector<double> cyclic(const std::vector<double>& a, std::vector<double> b, const std::vector<double>& c,
                           const std::vector<double>& r) {
  const std::size_t n = b.size(), last = n - 1;
  const double gamma = -b[0];
  std::vector<double> u(n, 0.0);
  u[0] = gamma;
  u[last] = c[last];
  b[0] -= gamma;
  b[last] -= a[0] * c[last] / gamma;
  auto x = tridiagonal(a, b, c, r);
  const auto z = tridiagonal(a, b, c, u);
  const double factor = (x[0] + a[0] / gamma * x[last]) / (1 + z[0] + a[0] / gamma * z[last]);
  for (std::size_t i = 0; i < n; ++i) x[i] -= factor * z[i];
  return x;
}

}  // namespace

std::vector<double> spline_slopes(const std::vector<std::pair<double, double>>& knots, SplineEnds ends) {
  const std::size_t pieces = knots.size() - 1;
  std::vector<double> inverse(pieces), bent(pieces);  // 1/h and 3 d/h²
  for (std::size_t i = 0; i < pieces; ++i) {
    inverse[i] = 1 / (knots[i + 1].first - knots[i].first);
    bent[i] = 3 * (knots[i + 1].second - knots[i].second) * inverse[i] * inverse[i];
  }
  if (ends == SplineEnds::periodic) {
    if (pieces == 1) return std::vector<double>(2, bent[0] / (3 * inverse[0]));
    if (pieces == 2) {  // both neighbours of a knot are the other one
      const double sum = inverse[0] + inverse[1], m = (bent[0] + bent[1]) / (3 * sum);
      return {m, m, m};
    }
    std::vector<double> a(pieces), b(pieces), c(pieces), r(pieces);
    for (std::size_t i = 0; i < pieces; ++i) {
      const std::size_t before = (i + pieces - 1) % pieces;
      a[i] = inverse[before];
      c[i] = inverse[i];
      b[i] = 2 * (a[i] + c[i]);
      r[i] = bent[before] + bent[i];
    }
    auto m = cyclic(a, b, c, r);
    m.push_back(m[0]);
    return m;
  }
  const std::size_t n = pieces + 1;
  std::vector<double> a(n, 0.0), b(n), c(n, 0.0), r(n);
  for (std::size_t i = 1; i < pieces; ++i) {
    a[i] = inverse[i - 1];
    c[i] = inverse[i];
    b[i] = 2 * (a[i] + c[i]);
    r[i] = bent[i - 1] + bent[i];
  }
  b[0] = b[pieces] = 1;
  r[0] = r[pieces] = 0;
  if (ends == SplineEnds::natural) {
    b[0] = 2 * inverse[0];
    c[0] = inverse[0];
    r[0] = bent[0];
    b[pieces] = 2 * inverse[pieces - 1];
    a[pieces] = inverse[pieces - 1];
    r[pieces] = bent[pieces - 1];
  }
  return tridiagonal(a, b, c, r);
}

}  // namespace freeplay
