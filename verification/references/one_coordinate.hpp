// One coordinate between walls on prescribed motions:
//
//     ẍ = a(t, x, ẋ),      g = side (x − w(t)) ≥ 0
//
// by the classical Runge–Kutta method of order 4 in tiny steps; an event within a step (contact
// with a wall, separation from it, a kink of a) is located by bisection of that step. At a rigid
// wall g⁺′ = −e g⁻′; a coordinate under load with an approach slower than `rest` stays at the wall
// until side (a − ẅ) > 0. A compliant wall pushes with
//
//     F/m = max(0, K δⁿ (1 + χ δ̇/v₀)),   δ = −g,   v₀ the approach at first contact,
//
// with the χ that delivers e. The first compression gives no v₀ for a wall that is compressed again
// before separation, or for one that is loaded after a contact slower than `rest`: with χ > 0 the
// motion is unknown from there on. No solver of the program is included. Units: those of x (m or
// rad) and s.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <vector>

#include "verification/references/curve_shapes.hpp"
#include "verification/references/delivered_restitution.hpp"
#include "verification/references/numerics.hpp"

namespace freeplay::reference {

struct MovingWall {
  std::function<CurvePoint(double)> place;  ///< w, ẇ, ẅ at t
  double side = 1;                          ///< 1: x is above it
  double restitution = 1;
  double stiffness = 0, exponent = 1.5;  ///< K/m of a compliant wall; 0: rigid
  /// e of an approach speed, in place of `restitution`
  std::function<double(double)> by_speed = {};

  double restitution_at(double approach) const { return by_speed ? by_speed(approach) : restitution; }
};

/// A change of a reference: a finer step, another start, or greater loads.
struct Change {
  double fine = 1;      ///< factor of its steps
  double x = 0, v = 0;  ///< added to the start
  double load = 0;      ///< relative, of accelerations
};

struct OneCoordinate {
  std::function<double(double, double, double)> acceleration;  ///< a(t, x, v)
  std::vector<MovingWall> walls = {};
  std::vector<double> kinks = {};        ///< positions where a has a kink
  std::vector<double> speed_kinks = {};  ///< speeds where a has a kink
  /// the first instant after t where a or a wall has a kink
  std::function<double(double)> next_kink = {};
  double x = 0, v = 0;            ///< at t = 0
  double step = 1e-3;             ///< s
  double step_in_contact = 1e-3;  ///< s, in a compliant wall
  /// speed below which a loaded contact stays closed
  double rest = 1e-9;

  struct Rows {
    std::vector<double> x, v;  ///< one for each requested instant
    std::size_t known = 0;     ///< number of these computed before the budget of steps was used up
    long impacts = 0;
    double first_contact = INFINITY;  ///< s
  };

  OneCoordinate under(const Change& c) const {
    auto one = *this;
    one.step *= c.fine, one.step_in_contact *= c.fine;
    one.x += c.x, one.v += c.v;
    if (c.load != 0)
      one.acceleration = [a = acceleration, more = 1 + c.load](double t, double x_, double v_) {
        return more * a(t, x_, v_);
      };
    return one;
  }

  Rows at(const std::vector<double>& instants, long most_steps = 1'000'000) const {
    Rows rows;
    Place p{0, x, v};
    std::vector<Contact> in(walls.size());
    for (std::size_t w = 0; w < walls.size(); ++w) {
      const double g = gap(w, p), rate = gap_rate(w, p);
      if (g <= 0 && walls[w].stiffness == 0 && std::abs(rate) <= rest && pressed(w, p)) in[w].held = true;
      if (g < 0 && walls[w].stiffness > 0) in[w].entered(std::max(-rate, rest), walls[w]);
    }
    long steps = 0;
    for (const double until : instants) {
      while (p.t < until) {
        if (++steps > most_steps) return rows;
        double h = inside(in) ? step_in_contact : step;
        if (next_kink) {
          const double next = next_kink(p.t);
          if (next > p.t && next < p.t + h) h = next - p.t;
        }
        if (p.t + h * (1 + 1e-12) >= until) h = until - p.t;
        advance(p, in, h, rows);
        if (std::any_of(in.begin(), in.end(), [](const Contact& c) { return c.anew; })) return rows;
        if (until - p.t <= 1e-15 * until) p.t = until;
      }
      rows.x.push_back(p.x);
      rows.v.push_back(p.v);
      ++rows.known;
    }
    return rows;
  }

 private:
  struct Place {
    double t, x, v;
  };
  struct Contact {
    bool held = false;    ///< at rest at a rigid wall
    bool inside = false;  ///< in a compliant one
    bool eased = false;   ///< at rest, or unloaded since
    bool anew = false;    ///< compressed again
    double v0 = 0, chi = 0;
    void entered(double speed, const MovingWall& wall) {
      inside = true, eased = false;
      v0 = speed;
      chi = static_cast<double>(exact_chi(wall.restitution_at(speed)));
    }
  };

  double gap(std::size_t w, const Place& p) const { return walls[w].side * (p.x - walls[w].place(p.t).y); }
  double gap_rate(std::size_t w, const Place& p) const {
    return walls[w].side * (p.v - walls[w].place(p.t).slope);
  }
  bool pressed(std::size_t w, const Place& p) const {
    // Released by more than rounding; otherwise contact and release would alternate without
    // progress of time.
    const double own = acceleration(p.t, p.x, p.v), bend = walls[w].place(p.t).bend;
    return walls[w].side * (own - bend) <= 1e-9 * (std::abs(own) + std::abs(bend));
  }
  static bool inside(const std::vector<Contact>& in) {
    return std::any_of(in.begin(), in.end(), [](const Contact& c) { return c.inside; });
  }
  double total(double t, double x_, double v_, const std::vector<Contact>& in) const {
    double a = acceleration(t, x_, v_);
    for (std::size_t w = 0; w < walls.size(); ++w) {
      if (!in[w].inside) continue;
      const auto at_wall = walls[w].place(t);
      const double depth = -walls[w].side * (x_ - at_wall.y), rate = -walls[w].side * (v_ - at_wall.slope);
      if (depth <= 0) continue;
      a += walls[w].side * walls[w].stiffness * std::pow(depth, walls[w].exponent) *
           std::max(0.0, 1 + in[w].chi * rate / in[w].v0);
    }
    return a;
  }
  /// `low`, `high`: the least and greatest position and speed of its stages.
  Place after(const Place& p, const std::vector<Contact>& in, double h, Place& low, Place& high) const {
    low = high = p;
    for (std::size_t w = 0; w < walls.size(); ++w)
      if (in[w].held) {
        const auto at_wall = walls[w].place(p.t + h);
        return {p.t + h, at_wall.y, at_wall.slope};
      }
    const auto stage = [&](double x_, double v_) {
      low.x = std::min(low.x, x_), high.x = std::max(high.x, x_);
      low.v = std::min(low.v, v_), high.v = std::max(high.v, v_);
    };
    const double k1 = total(p.t, p.x, p.v, in);
    const double v2 = p.v + 0.5 * h * k1, k2 = total(p.t + 0.5 * h, p.x + 0.5 * h * p.v, v2, in);
    const double v3 = p.v + 0.5 * h * k2, k3 = total(p.t + 0.5 * h, p.x + 0.5 * h * v2, v3, in);
    const double v4 = p.v + h * k3, k4 = total(p.t + h, p.x + h * v3, v4, in);
    const Place q{p.t + h, p.x + h / 6 * (p.v + 2 * v2 + 2 * v3 + v4),
                  p.v + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)};
    stage(p.x + 0.5 * h * p.v, v2), stage(p.x + 0.5 * h * v2, v3), stage(p.x + h * v3, v4), stage(q.x, q.v);
    return q;
  }

  void follow(const Place& p, std::vector<Contact>& in) const {
    for (std::size_t w = 0; w < walls.size(); ++w) {
      auto& c = in[w];
      if (!c.inside || c.chi == 0) continue;
      const double depth = std::max(-gap(w, p), 0.0), rate = -gap_rate(w, p), n = walls[w].exponent;
      c.eased = c.eased || rate < 0;
      // The approach speed that gives the same penetration.
      c.anew = c.eased && rate > 0 &&
               (rate * rate + 2 * walls[w].stiffness * std::pow(depth, n + 1) / (n + 1) > c.v0 * c.v0 ||
                c.v0 > rest);
    }
  }
  /// One step of h, or up to the first event in it.
  void advance(Place& p, std::vector<Contact>& in, double h, Rows& rows) const {
    // Whether an event has occurred between p and q.
    enum class What { none, release, wall, out, kink };
    std::size_t which = 0;
    // A state at a kink is beyond it by more than rounding, otherwise the step would begin with the
    // force before it.
    for (const double k : kinks)
      if (const double near = 1e-13 * (std::abs(k) + h * std::abs(p.v));
          p.v != 0 && std::abs(p.x - k) <= near)
        p.x = k + std::copysign(2 * near, p.v);
    Place low = p, high = p;
    const auto go = [&](double length) { return after(p, in, length, low, high); };
    const auto happens = [&](const Place& q) {
      for (std::size_t w = 0; w < walls.size(); ++w) {
        if (in[w].held) {
          which = w;
          return pressed(w, q) ? What::none : What::release;
        }
        const double g = gap(w, q);
        const double rounding = 4e-16 * std::abs(q.x);
        if (in[w].inside ? g > 0 : g < 0 && ((gap(w, p) > 0 && g < -rounding) || gap_rate(w, q) < 0)) {
          which = w;
          return in[w].inside ? What::out : What::wall;
        }
      }
      // A force may jump at a kink: no stage may be beyond it.
      for (const double k : kinks)
        if (low.x < k && k < high.x) return What::kink;
      for (const double k : speed_kinks)
        if (low.v < k && k < high.v) return What::kink;
      return What::none;
    };
    Place q = go(h);
    if (happens(q) == What::none) {
      // Contact and separation within the step, at nearly zero speed.
      for (std::size_t w = 0; w < walls.size(); ++w) {
        if (in[w].held || in[w].inside || !(gap_rate(w, p) < 0 && gap_rate(w, q) > 0)) continue;
        double before = 0, behind = h;
        bisect(before, behind, 60, [&](double middle) { return gap_rate(w, go(middle)) < 0; });
        if (gap(w, go(before)) < 0 && before < h) return advance(p, in, before, rows);
      }
      p = q;
      follow(p, in);
      return;
    }
    double before = 0, behind = h;
    for (int i = 0; i < 60 && behind - before > 1e-16 * (p.t + h); ++i) {
      const double middle = 0.5 * (before + behind);
      (happens(go(middle)) == What::none ? before : behind) = middle;
    }
    q = go(behind);
    const What what = happens(q);
    if (what == What::kink && before > 1e-15 * (p.t + h)) {  // up to it; the next step passes it
      p = go(before);
      return;
    }
    p = q;
    auto& c = in[which];
    const auto& wall = walls.empty() ? MovingWall{} : walls[which];
    if (what == What::release) c.held = false;
    if (what == What::out) c.inside = false;
    if (what == What::wall) {
      rows.first_contact = std::min(rows.first_contact, p.t);
      const double approach = -gap_rate(which, p);
      if (wall.stiffness > 0) {
        c.entered(std::max(approach, rest), wall);
        c.eased = approach < rest;
        return;
      }
      ++rows.impacts;
      const auto at_wall = wall.place(p.t);
      p.x = at_wall.y;
      const double e = wall.restitution_at(std::max(approach, 0.0));
      p.v = at_wall.slope + wall.side * e * std::max(approach, 0.0);
      // Flights no higher than the rounding of a position do not count.
      const double a = std::abs(acceleration(p.t, p.x, p.v) - at_wall.bend);
      const double slow = std::max(rest, 4 * std::sqrt(2 * a * 8e-16 * std::abs(p.x)));
      if (e * approach <= slow && pressed(which, p)) {
        c.held = true;
        p.v = at_wall.slope;
      }
    }
  }
};

}  // namespace freeplay::reference
