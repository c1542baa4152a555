// One coordinate under a force with kinks, solved piece by piece in closed form. No solver of the
// program is included. Units: m, s, N, kg (or rad, s, N m, kg m²).
//
// SpeedCurve: m v̇ = F(v), F a table of straight lines. On a piece, with r = F/m and b = F′/m,
//
//     v(t) = v + r (e^{bt} − 1)/b,     x(t) = x − a t/b + (v + a/b)(e^{bt} − 1)/b,   a = r − b v,
//
// and a knot v* is reached at t = ln(r*/r)/b, or never, where the force at it has the other sign.
//
// SaturatedAxis: J θ̈ = sat(k_p (s − θ) − k_d θ̇, L), from θ = 0. At the limit θ is a parabola, else
// a damped oscillation about s; the instants at which the demand reaches the limit are bisected on
// these functions.
#pragma once

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>
#include <vector>

namespace freeplay::reference {

class SpeedCurve {
 public:
  struct Knot {
    double v, force;
  };
  /// From x = 0 at speed v; `knots`: at least two, increasing in v.
  SpeedCurve(std::vector<Knot> knots, double m, double v) : knots_(std::move(knots)), m_(m), v_(v) {
    while (piece_ + 2 < knots_.size() && knots_[piece_ + 1].v <= v) ++piece_;
    if (piece_ > 0 && knots_[piece_].v == v && rate() < 0) --piece_;
  }
  /// Advances to `time`, not before the last call's.
  void advance(double time) {
    while (true) {
      const double r = rate(), b = slope();
      const bool up = r > 0, end = up ? piece_ + 2 == knots_.size() : piece_ == 0;
      double to = INFINITY;
      if (r != 0 && !end) {
        const double knot = knots_[up ? piece_ + 1 : piece_].v, there = r + b * (knot - v_);
        if (there * r > 0) to = std::abs(there / r - 1) > 1e-12 ? std::log(there / r) / b : (knot - v_) / r;
        if (t_ + to < time) {
          move(to);
          v_ = knot;
          t_ += to;
          piece_ += up ? 1 : -1;
          continue;
        }
      }
      move(time - t_);
      t_ = time;
      return;
    }
  }
  double v() const { return v_; }
  double x() const { return x_; }

 private:
  double slope() const {
    const auto &p = knots_[piece_], &q = knots_[piece_ + 1];
    return (q.force - p.force) / (q.v - p.v) / m_;
  }
  double rate() const { return knots_[piece_].force / m_ + slope() * (v_ - knots_[piece_].v); }
  void move(double t) {
    const double r = rate(), b = slope();
    if (std::abs(b * t) < 1e-8) {
      x_ += t * (v_ + 0.5 * r * t);
      v_ += r * t * (1 + 0.5 * b * t);
      return;
    }
    const double grown = std::expm1(b * t) / b;
    x_ += v_ * t + r / b * (grown - t);
    v_ += r * grown;
  }
  std::vector<Knot> knots_;
  double m_, v_, x_ = 0, t_ = 0;
  std::size_t piece_ = 0;
};

struct SaturatedAxis {
  double J, stiffness, damping, target, limit;
  double angle = 0, speed = 0;

  double demand(double at, double rate) const { return stiffness * (target - at) - damping * rate; }
  /// Advances by `time`.
  void advance(double time) {
    double rest = time;
    while (rest > 0) {
      const double u = demand(angle, speed), du = -stiffness * speed - damping * sign(u) * limit / J;
      const bool at_limit = std::abs(std::abs(u) - limit) <= 1e-12 * limit;
      const int side = (at_limit ? u * du > 0 : std::abs(u) > limit) ? sign(u) : 0;
      const double step = std::min(rest, side != 0 ? until_inside(side) : 0.02 / std::sqrt(stiffness / J));
      const auto next = after(side, step);
      const double last = demand(next.first, next.second);
      const bool kept = side != 0 || std::abs(last) <= limit;
      double low = 0, high = step;
      for (int k = 0; !kept && k < 100; ++k) {
        const double middle = 0.5 * (low + high);
        const auto now = after(side, middle);
        (std::abs(demand(now.first, now.second)) <= limit ? low : high) = middle;
      }
      std::tie(angle, speed) = kept ? next : after(side, high);
      rest -= kept ? step : high;
    }
  }

 private:
  static int sign(double x) { return x < 0 ? -1 : 1; }
  /// The time at which the demand, side·(u − side·L) > 0 now, comes back to the limit.
  double until_inside(int side) const {
    // u = k_p (s − θ − ω t − ½ α t²) − k_d (ω + α t) = side L, with α = side L/J
    const double alpha = side * limit / J, a = -0.5 * stiffness * alpha,
                 b = -stiffness * speed - damping * alpha, c = demand(angle, speed) - side * limit;
    const double root = std::sqrt(b * b - 4 * a * c);
    double least = INFINITY;
    for (const double t : {(-b + root) / (2 * a), (-b - root) / (2 * a)})
      if (t > 1e-13 && t < least && std::isfinite(t)) least = t;
    return least;
  }
  std::pair<double, double> after(int side, double t) const {
    if (side != 0) {
      const double alpha = side * limit / J;
      return {angle + t * (speed + 0.5 * alpha * t), speed + alpha * t};
    }
    const double d = damping / (2 * J), w = std::sqrt(stiffness / J - d * d), e = std::exp(-d * t),
                 x = angle - target, p = (speed + d * x) / w, c = std::cos(w * t), s = std::sin(w * t);
    const double moved = e * (x * c + p * s);
    return {target + moved, e * w * (p * c - x * s) - d * moved};
  }
};

}  // namespace freeplay::reference
