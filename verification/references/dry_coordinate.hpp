// One coordinate with set-valued dry friction against a support of constant speed w:
//
//     ẍ = a(side, t, x, ẋ)      side = sgn(ẋ − w) where it slides, with the friction of that side in a
//     ẋ = w                     sticking: as long as a(+1) ≤ 0 ≤ a(−1) at that speed
//
// The two accelerations may differ in any way: by a bound for each direction, or one that depends on the
// speed or on the coordinate's own acceleration. By the classical Runge–Kutta method of order 4 in tiny
// steps; the instants at which sliding ends and sticking ends are bisected. No solver of the program is
// included. Units: those of x (m or rad) and s.
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include "verification/references/numerics.hpp"
#include "verification/references/one_coordinate.hpp"

namespace freeplay::reference {

struct DryCoordinate {
  std::function<double(int side, double t, double x, double v)> acceleration;
  double support = 0;                            ///< w
  std::function<double(double)> next_kink = {};  ///< the first instant after t where a has a kink
  double x = 0, v = 0;                           ///< at t = 0
  double step = 1e-3;                            ///< s

  DryCoordinate under(const Change& c) const {
    auto one = *this;
    one.step *= c.fine;
    one.x += c.x, one.v += c.v;
    if (c.load != 0)
      one.acceleration = [a = acceleration, more = 1 + c.load](int side, double t, double x_, double v_) {
        return more * a(side, t, x_, v_);
      };
    return one;
  }

  OneCoordinate::Rows at(const std::vector<double>& instants, long most_steps = 1'000'000) const {
    OneCoordinate::Rows rows;
    Place p{0, x, v};
    int side = v > support ? 1 : v < support ? -1 : side_from_rest(p);
    long steps = 0;
    for (const double until : instants) {
      while (p.t < until) {
        if (++steps > most_steps) return rows;
        double h = step;
        if (next_kink)
          if (const double next = next_kink(p.t); next > p.t) h = std::min(h, next - p.t);
        h = std::min(h, until - p.t);
        advance(p, side, h);
        if (until - p.t <= 1e-15 * until) p.t = until;
      }
      rows.x.push_back(p.x), rows.v.push_back(p.v);
      ++rows.known;
    }
    return rows;
  }

 private:
  struct Place {
    double t, x, v;
  };
  int side_from_rest(const Place& p) const {
    if (acceleration(1, p.t, p.x, support) > 0) return 1;
    return acceleration(-1, p.t, p.x, support) < 0 ? -1 : 0;
  }
  Place after(const Place& p, int side, double h) const {
    if (side == 0) return {p.t + h, p.x + support * h, support};
    const auto a = [&](double t, double x_, double v_) { return acceleration(side, t, x_, v_); };
    const double k1 = a(p.t, p.x, p.v);
    const double v2 = p.v + 0.5 * h * k1, k2 = a(p.t + 0.5 * h, p.x + 0.5 * h * p.v, v2);
    const double v3 = p.v + 0.5 * h * k2, k3 = a(p.t + 0.5 * h, p.x + 0.5 * h * v2, v3);
    const double v4 = p.v + h * k3, k4 = a(p.t + h, p.x + h * v3, v4);
    return {p.t + h, p.x + h / 6 * (p.v + 2 * v2 + 2 * v3 + v4), p.v + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)};
  }
  /// One step of h, or up to the end of sliding or sticking in it.
  void advance(Place& p, int& side, double h) const {
    const auto lasts = [&](double length) {
      const auto q = after(p, side, length);
      return side == 0 ? side_from_rest(q) == 0 : side * (q.v - support) >= 0;
    };
    if (lasts(h)) {
      p = after(p, side, h);
      return;
    }
    double before = 0, behind = h;
    for (int i = 0; i < 100 && behind - before > 1e-16 * (p.t + h); ++i) {
      const double middle = 0.5 * (before + behind);
      (lasts(middle) ? before : behind) = middle;
    }
    p = after(p, side, behind);
    p.v = support;
    side = side_from_rest(p);
  }
};

}  // namespace freeplay::reference
