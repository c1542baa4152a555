// One coordinate under a force with kinks, solved piece by piece in closed form: m v̇ = F(v), F a
// table of straight lines. No solver of the program is included. Units: m, s, N, kg (or rad, s,
// N m, kg m²). On a piece, with r = F/m and b = F′/m,
//
//     v(t) = v + r (e^{bt} − 1)/b,     x(t) = x − a t/b + (v + a/b)(e^{bt} − 1)/b,   a = r − b v,
//
// and a knot v* is reached at t = ln(r*/r)/b, or never, where the force at it has the other sign.
#pragma once

#include <algorithm>
#include <cmath>
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

}  // namespace freeplay::reference
