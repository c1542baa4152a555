// Checks of contact rows and of bounds of gaps that hold for every kind of contact.
#pragma once

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "dynamics/system.hpp"
#include "verification/support/rig.hpp"

namespace freeplay::test {

/// Uniform random numbers from one seed.
struct Uniform {
  std::mt19937 engine{20261130};
  double operator()(double low, double high) {
    return std::uniform_real_distribution<double>{low, high}(engine);
  }
  std::vector<double> vector(int n, double size = 1) {
    std::vector<double> x(static_cast<std::size_t>(n));
    for (auto& y : x) y = (*this)(-size, size);
    return x;
  }
};

/// q + t v
inline std::vector<double> along(std::vector<double> q, const std::vector<double>& v, double t) {
  for (std::size_t i = 0; i < q.size(); ++i) q[i] += t * v[i];
  return q;
}

/// The row of contact k at q with the velocities v, and its central differences over the times ±h of the
/// motion q + t v. Checks that the row has the system's gap.
class RowDifferences {
 public:
  RowDifferences(const System& system, int k, const std::vector<double>& q, const std::vector<double>& v,
                 double h)
      : v_(v), h_(h) {
    auto e = system.make_evaluation();
    const auto read = [&](const std::vector<double>& at, ContactRow& into) {
      system.place(0, at.data(), e);
      system.contact(k, at.data(), v.data(), e, into);
    };
    read(along(q, v, -h), before_);
    read(along(q, v, h), after_);
    read(q, row);
    CHECK(row.gap == system.gap(k, q.data(), e));
  }
  ContactRow row;
  /// ġ by the row, and by differences.
  double rate() const { return row.normal.dot(v_.data()); }
  double gap_slope() const { return (after_.gap - before_.gap) / (2 * h_); }
  /// γ by differences: −d(n·v)/dt at constant v.
  double gamma_n() const { return -change(&ContactRow::normal); }
  double gamma_t() const { return -change(&ContactRow::tangent); }
  /// Difference of γ_N over the interval, great where the slope of ġ jumps.
  double gamma_jump() const { return std::abs(after_.gamma_n - before_.gamma_n); }
  /// Checks that rotating both bodies about one point at 0.7 rad/s closes no gap; the surfaces slide by
  /// `slide` (m/s).
  void check_common_rotation(const std::vector<double>& q, double slide) const {
    std::vector<double> common(6);
    for (const std::size_t b : {0, 1}) {
      common[3 * b] = 0.3 - 0.7 * q[3 * b + 1];
      common[3 * b + 1] = -0.2 + 0.7 * q[3 * b];
      common[3 * b + 2] = 0.7;
    }
    CHECK(row.normal.dot(common.data()) == Approx(0).margin(1e-12));
    CHECK(row.tangent.dot(common.data()) == Approx(slide).margin(1e-12));
  }

 private:
  double change(SparseRow ContactRow::*side) const {
    return ((after_.*side).dot(v_.data()) - (before_.*side).dot(v_.data())) / (2 * h_);
  }
  const std::vector<double>& v_;
  double h_;
  ContactRow before_, after_;
};

/// Bounds of the gap of contact k over a time h of the motion q + t v, beside its least value in samples.
struct GapBounds {
  double bound = 0, least = INFINITY;
  bool rises = false, falls = false;  ///< proved by the bounds
};
/// Checks that a gap that is proved to rise or fall does so in all samples.
inline GapBounds gap_bounds(const System& system, int k, const std::vector<double>& q,
                            const std::vector<double>& v, double h, int samples) {
  auto e = system.make_evaluation();
  ContactRow row;
  const auto at = [&](double t) {
    const auto now = along(q, v, t);
    system.place(0, now.data(), e);
    system.contact(k, now.data(), v.data(), e, row);
    return Watched{row.gap, row.normal.dot(v.data())};
  };
  MotionBounds bounds;
  bounds.duration = h;
  bounds.acceleration.assign(v.size(), 0);
  for (const double x : v) bounds.speed.push_back(std::abs(x));
  const auto start = at(0), end = at(h);
  const auto motion = system.gap_motion(k, bounds, along(q, v, h).data(), e);
  GapBounds found;
  double slowest = INFINITY, fastest = -INFINITY;
  for (int i = 0; i <= samples; ++i) {
    const auto sample = at(h * i / samples);
    found.least = std::min(found.least, sample.value);
    slowest = std::min(slowest, sample.rate);
    fastest = std::max(fastest, sample.rate);
  }
  found.bound = motion.least(start, end, h);
  found.rises = motion.rises(start, end, h);
  found.falls = motion.falls(start, end, h);
  if (found.rises) CHECK(slowest > 0);
  if (found.falls) CHECK(fastest < 0);
  return found;
}

}  // namespace freeplay::test
