// StepCourse: a scalar w(t) of the state, on the dense output of a step, with its rate and a bound of
// its second derivative. Speeds and the demands of controllers contain velocities, whose second
// derivatives no bound of the bodies' motion covers. w is therefore represented by its Chebyshev
// interpolant of degree N = 8,
//
//     w = Σ c_k T_k(s),  s = 2 (t − t0)/h − 1,      |ẅ| ≤ (2/h)² Σ |c_k| k² (k² − 1)/3,
//
// which is exact where the dense output is a polynomial (dopri5: degree 4, Hermite: 3) and w is
// linear in the state. First crossings of a value follow by first_loss() (crossing.hpp).
#pragma once

#include <array>
#include <cmath>
#include <cstddef>

#include "dynamics/gap_motion.hpp"

namespace freeplay {

class StepCourse {
 public:
  static constexpr std::size_t degree = 8;
  /// Time of sample k = 0 to `degree` of a step from t0 to t1; the samples begin at t1.
  static double time(double t0, double t1, std::size_t k) {
    if (k == 0) return t1;
    return k == degree ? t0 : t0 + 0.5 * (t1 - t0) * (1 + nodes()[k]);
  }
  StepCourse() = default;
  /// `w`: the samples.
  StepCourse(double t0, double t1, const std::array<double, degree + 1>& w) : t0_(t0), t1_(t1) {
    const auto& node = nodes();
    for (std::size_t k = 0; k <= degree; ++k) {
      double sum = 0;
      for (std::size_t j = 0; j <= degree; ++j) {
        const std::size_t turn = (j * k) % (2 * degree);  // cos(π j k/N)
        const double cosine = turn <= degree ? node[turn] : node[2 * degree - turn];
        sum += (j == 0 || j == degree ? 0.5 : 1) * w[j] * cosine;
      }
      c_[k] = (k == 0 || k == degree ? 1.0 : 2.0) / degree * sum;
      largest_ = std::fmax(largest_, std::abs(w[k]));
    }
    const double per = 2 / (t1 - t0);
    for (std::size_t k = 2; k <= degree; ++k)
      bend_ += per * per * std::abs(c_[k]) * static_cast<double>(k * k * (k * k - 1)) / 3;
  }
  double bend() const { return bend_; }
  /// Greatest |w| of the samples.
  double largest() const { return largest_; }
  /// ẇ at t: Σ c_k k U_{k−1}(s) · 2/h.
  double rate(double t) const {
    const double s = std::fmin(1, std::fmax(-1, 2 * (t - t0_) / (t1_ - t0_) - 1));
    double before = 0, u = 1, sum = 0;
    for (std::size_t k = 1; k <= degree; ++k) {
      sum += static_cast<double>(k) * c_[k] * u;
      const double next = 2 * s * u - before;
      before = u;
      u = next;
    }
    return sum * 2 / (t1_ - t0_);
  }

 private:
  static const std::array<double, degree + 1>& nodes() {
    static const auto list = [] {
      std::array<double, degree + 1> x{};
      for (std::size_t k = 0; k <= degree; ++k)
        x[k] = std::cos(3.141592653589793 * static_cast<double>(k) / degree);
      return x;
    }();
    return list;
  }
  double t0_ = 0, t1_ = 0, bend_ = 0, largest_ = 0;
  std::array<double, degree + 1> c_{};
};

}  // namespace freeplay
