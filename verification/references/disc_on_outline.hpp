// A disc in the plane against a rigid convex outline that turns at constant speed about the origin, without
// friction. The outline is the polygon through the centres c_k of its corners' arcs, enlarged by their
// radius r; with the disc's radius R and its centre p in the axes of the outline,
//
//     g = min_k dist(p, segment c_k c_{k+1}) − (r + R),     n = ∇g
//
// Between contacts p moves on a parabola. A rigid contact gives ġ⁺ = −e ġ⁻ along n; a compliant one pushes
// with max(0, K δ (1 + χ δ̇/v₀)), δ = −g, v₀ the approach at the onset, with the χ that delivers e. Onsets and
// separations are bisected; the contact is integrated by the classical Runge–Kutta method. The motion is
// unknown from a compliant contact that is compressed again, and from a rigid approach below `rest`. No
// solver of the program is included. Units: m, s, kg, rad.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "verification/references/delivered_restitution.hpp"
#include "verification/references/numerics.hpp"
#include "verification/references/one_coordinate.hpp"
#include "verification/references/planar.hpp"

namespace freeplay::reference {

struct DiscOnOutline {
  using Point = Planar<double>;
  std::vector<Point> centres;  ///< c_k; two: a thin face
  double reach = 0;            ///< r + R
  double spin = 0;             ///< rad/s, of the outline, at angle 0 at t = 0
  Point gravity{0, 0};
  double restitution = 1;
  double stiffness = 0;  ///< K/m; 0: rigid
  Point at{0, 0}, velocity{0, 0};
  double step = 1e-3, step_in_contact = 1e-3;  ///< s
  double rest = 1e-9;                          ///< m/s, least v₀

  struct Rows {
    std::vector<Point> p, v;
    std::vector<double> onsets;  ///< s
  };

  DiscOnOutline under(const Change& c) const {
    auto one = *this;
    one.step *= c.fine, one.step_in_contact *= c.fine;
    one.at = one.at + Point{c.x, 0.7 * c.x}, one.velocity = one.velocity + Point{c.v, -0.6 * c.v};
    one.gravity = (1 + c.load) * one.gravity;
    one.spin *= 1 + c.load;
    return one;
  }

  Rows rows(const std::vector<double>& instants, long most_steps = 1'000'000) const {
    Rows list;
    Place s{0, at, velocity};
    Contact in;
    long steps = 0;
    for (const double until : instants) {
      while (s.t < until) {
        if (++steps > most_steps) return list;
        advance(s, in, std::min(in.inside ? step_in_contact : step, until - s.t), list);
        if (in.unknown) return list;
        if (until - s.t <= 1e-15 * until) s.t = until;
      }
      list.p.push_back(s.p), list.v.push_back(s.v);
    }
    return list;
  }

 private:
  struct Place {
    double t;
    Point p, v;
  };
  struct Contact {
    bool inside = false, eased = false, unknown = false;
    double v0 = 0, chi = 0;
  };
  struct Gap {
    double g, rate;
    Point n;
  };
  Gap gap(const Place& s) const {
    const double c = std::cos(spin * s.t), d = std::sin(spin * s.t);
    const Point x{c * s.p.x + d * s.p.y, -d * s.p.x + c * s.p.y};
    double least = INFINITY;
    Point from{0, 0};
    for (std::size_t k = 0; k < centres.size(); ++k) {
      const Point a = centres[k], along = centres[(k + 1) % centres.size()] - a;
      const double share = std::clamp(dot(x - a, along) / dot(along, along), 0.0, 1.0);
      const Point off = x - a - share * along;
      if (const double apart = std::hypot(off.x, off.y); apart < least) least = apart, from = off;
    }
    const Point u = (1 / least) * from, n{c * u.x - d * u.y, d * u.x + c * u.y};
    return {least - reach, dot(n, s.v - spin * quarter_turn(s.p)), n};
  }
  Point pull(const Place& s, const Contact& in) const {
    if (!in.inside) return gravity;
    const auto g = gap(s);
    const double depth = std::max(-g.g, 0.0);
    return gravity + stiffness * depth * std::max(0.0, 1 - in.chi * g.rate / in.v0) * g.n;
  }
  Place after(const Place& s, const Contact& in, double h) const {
    if (!in.inside) return {s.t + h, s.p + h * s.v + 0.5 * h * h * gravity, s.v + h * gravity};
    const auto a = [&](double later, Point p, Point v) { return pull({s.t + later, p, v}, in); };
    const Point k1 = a(0, s.p, s.v), v2 = s.v + 0.5 * h * k1;
    const Point k2 = a(0.5 * h, s.p + 0.5 * h * s.v, v2), v3 = s.v + 0.5 * h * k2;
    const Point k3 = a(0.5 * h, s.p + 0.5 * h * v2, v3), v4 = s.v + h * k3;
    const Point k4 = a(h, s.p + h * v3, v4);
    return {s.t + h, s.p + h / 6 * (s.v + 2 * v2 + 2 * v3 + v4), s.v + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)};
  }
  /// One step of h, or up to the first onset or separation in it.
  void advance(Place& s, Contact& in, double h, Rows& list) const {
    const auto go = [&](double length) { return after(s, in, length); };
    const auto changes = [&](const Place& q) {
      const auto g = gap(q);
      return in.inside ? g.g > 0 : g.g < 0 && g.rate < 0;
    };
    if (!changes(go(h))) {
      // Onset and separation within the step, nearly tangential.
      if (!in.inside && gap(s).rate < 0 && gap(go(h)).rate > 0) {
        double before = 0, behind = h;
        bisect(before, behind, 60, [&](double middle) { return gap(go(middle)).rate < 0; });
        if (changes(go(before)) && before < h) return advance(s, in, before, list);
      }
      s = go(h);
      if (!in.inside || in.chi == 0) return;
      const double rate = -gap(s).rate;
      in.eased = in.eased || rate < 0;
      in.unknown = in.eased && rate > 0;
      return;
    }
    double before = 0, behind = h;
    bisect(before, behind, 60, [&](double middle) { return !changes(go(middle)); });
    s = go(behind);
    if (in.inside) {
      in = {};
      return;
    }
    const auto g = gap(s);
    list.onsets.push_back(s.t);
    in.unknown = -g.rate < rest;
    if (stiffness > 0)
      in.inside = true, in.v0 = -g.rate, in.chi = static_cast<double>(exact_chi(restitution));
    else
      s.v = s.v + -(1 + restitution) * g.rate * g.n;
  }
};

}  // namespace freeplay::reference
