// The deviation p(φ) of a surface from its nominal radius, with two derivatives: the sum of a Fourier series and
// of a cubic spline through points in one turn, which is periodic with continuous second derivatives.
//
// Spline: with the second derivatives M_k at the points (φ_k, p_k) and h_k = φ_{k+1} − φ_k, all with the period
// 2π,
//
//     h_{k−1} M_{k−1} + 2 (h_{k−1} + h_k) M_k + h_k M_{k+1} = 6 ((p_{k+1} − p_k)/h_k − (p_k − p_{k−1})/h_{k−1})
//
// Sign convention: p > 0 where the radius is larger. Units: rad, m.
// Source: de Boor, A Practical Guide to Splines, 1978, chapter IV.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "verification/references/numerics.hpp"

namespace freeplay::reference {

class SurfaceDeviation {
 public:
  /// p (m), p′ (m/rad) and p″ (m/rad²).
  struct Value {
    double p = 0, slope = 0, bend = 0;
  };

  SurfaceDeviation() = default;
  /// `harmonics`: rows n, cosine, sine; `points`: increasing angles within a turn, none or three and more.
  explicit SurfaceDeviation(std::vector<std::array<double, 3>> harmonics,
                            std::vector<std::pair<double, double>> points = {})
      : harmonics_(std::move(harmonics)), points_(std::move(points)) {
    const std::size_t n = points_.size();
    if (n == 0) return;
    std::vector<std::vector<double>> a(n, std::vector<double>(n));
    bends_.resize(n);
    for (std::size_t k = 0; k < n; ++k) {
      const std::size_t before = (k + n - 1) % n, next = (k + 1) % n;
      const double h = width(before), w = width(k);
      a[k][before] += h, a[k][k] += 2 * (h + w), a[k][next] += w;
      bends_[k] = 6 * ((points_[next].second - points_[k].second) / w -
                       (points_[k].second - points_[before].second) / h);
    }
    eliminate(a, bends_);
  }

  Value at(double phi) const {
    Value y;
    for (const auto& [n, cosine, sine] : harmonics_) {
      const double c = std::cos(n * phi), s = std::sin(n * phi), even = cosine * c + sine * s;
      y.p += even;
      y.slope += n * (sine * c - cosine * s);
      y.bend -= n * n * even;
    }
    if (!points_.empty()) add_spline(phi, y);
    return y;
  }
  bool is_zero() const { return harmonics_.empty() && points_.empty(); }

 private:
  static constexpr double turn = 6.283185307179586;
  double width(std::size_t k) const {
    return k + 1 < points_.size() ? points_[k + 1].first - points_[k].first
                                  : points_[0].first + turn - points_[k].first;
  }
  void add_spline(double phi, Value& y) const {
    const double x = phi - turn * std::floor((phi - points_[0].first) / turn);
    const auto above = std::upper_bound(points_.begin(), points_.end(), x,
                                        [](double at, const auto& point) { return at < point.first; });
    const auto k = static_cast<std::size_t>(std::max(above - points_.begin(), std::ptrdiff_t{1}) - 1);
    const std::size_t next = (k + 1) % points_.size();
    const double h = width(k), u = (x - points_[k].first) / h, w = 1 - u;
    const double p0 = points_[k].second, p1 = points_[next].second, m0 = bends_[k], m1 = bends_[next];
    y.p += w * p0 + u * p1 + h * h / 6 * ((w * w * w - w) * m0 + (u * u * u - u) * m1);
    y.slope += (p1 - p0) / h + h / 6 * ((3 * u * u - 1) * m1 - (3 * w * w - 1) * m0);
    y.bend += w * m0 + u * m1;
  }

  std::vector<std::array<double, 3>> harmonics_;
  std::vector<std::pair<double, double>> points_;
  std::vector<double> bends_;  // m/rad², second derivatives at the points
};

}  // namespace freeplay::reference
