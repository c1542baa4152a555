// Cams: the forces on a follower in steady contact, and the first contact of one in free motion.
//
// A cam that turns at ω under a follower that is guided straight towards the cam's axis, m its mass
// (kg), pressed down by a spring (k, and F₀ at no lift) and weight. With the angle φ = ωt since no
// lift, in steady contact,
//
//     y = h(φ),    P = m ω² h'' + k h + F₀ + m g           contact force along the guide
//
// Eccentric disc, h = e (1 − cos φ), under a flat face: N = P, and
//
//     P = (m ω² − k) e cos φ + k e + F₀ + m g
//
// reaches zero first at φ = π when m e ω² = 2 k e + F₀ + m g (the jump speed), beyond that where
// cos φ = −(k e + F₀ + m g)/((m ω² − k) e). The cam's torque against its turning is M = N h' and,
// with friction of the face sliding on the cam's profile, μ N (R + h) in addition. Roller on the
// pitch curve r = r₀ + h: pressure angle tan α = h'/r, N = P/cos α without friction, M = P h'.
// Source: Norton, Cam Design and Manufacturing Handbook, on follower dynamics; here from Newton's
// law.
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "verification/references/numerics.hpp"

namespace freeplay::reference {

struct EccentricCam {
  double eccentricity;  ///< m, e
  double mass;          ///< kg, of the follower
  double stiffness;     ///< N/m
  double preload;       ///< N, spring and weight at no lift
  double radius;        ///< m, R, of the cam at no lift; of a roller's pitch curve
  double friction = 0;

  double lift(double phi) const { return eccentricity * (1 - std::cos(phi)); }
  double slope(double phi) const { return eccentricity * std::sin(phi); }
  double press(double phi, double speed) const {
    return mass * speed * speed * eccentricity * std::cos(phi) + stiffness * lift(phi) + preload;
  }
  double jump_speed() const {
    return std::sqrt((2 * stiffness * eccentricity + preload) / (mass * eccentricity));
  }
  /// φ of the first loss of contact, above the jump speed.
  double lost_at(double speed) const {
    return std::acos(-(stiffness * eccentricity + preload) /
                     ((mass * speed * speed - stiffness) * eccentricity));
  }
  /// Time after the loss of contact (s) and rate (m/s) of the landing: y = y_e + (y₀ − y_e) cos
  /// νt + ẏ₀/ν sin νt, ν² = k/m, y_e = −preload/k, against h; the first root by steps of 1e-6 of a
  /// revolution and bisection.
  struct Landing {
    double after, rate;
  };
  Landing landing(double speed) const {
    const double phi = lost_at(speed), nu = std::sqrt(stiffness / mass), rest = -preload / stiffness;
    const double y0 = lift(phi) - rest, v0 = speed * slope(phi);
    const auto gap = [&](double t) {
      return rest + y0 * std::cos(nu * t) + v0 / nu * std::sin(nu * t) - lift(phi + speed * t);
    };
    const double h = 1e-6 * 2 * M_PI / speed;
    // before that, a gap that opens with its third derivative is zero within rounding
    double low = 1000 * h;
    while (gap(low + h) > 0) low += h;
    double high = low + h;
    bisect(low, high, 60, [&](double x) { return gap(x) > 0; });
    return {low, v0 * std::cos(nu * low) - y0 * nu * std::sin(nu * low) - speed * slope(phi + speed * low)};
  }
  double torque_flat(double phi, double speed) const {
    return press(phi, speed) * (slope(phi) + friction * (radius + lift(phi)));
  }
  double torque_roller(double phi, double speed) const { return press(phi, speed) * slope(phi); }
  double normal_roller(double phi, double speed) const {
    return press(phi, speed) / std::cos(std::atan2(slope(phi), radius + lift(phi)));
  }
};

// First contact of a cam with a follower in free motion, by brute force. The cam turns about its
// point, the origin, at a constant rate; the follower's point moves on a parabola. Lifts are those of
// the periodic cubic spline through equidistant values; its second derivatives m satisfy
//
//     m_{i−1} + 4 m_i + m_{i+1} = 6 (y_{i−1} − 2 y_i + y_{i+1})/w²
//
// and are found by Gauss–Seidel iteration. The distance of a roller's centre to the pitch curve is the
// least over points all around it, refined by golden sections; that of a flat face is its formula. Time
// advances by the distance over the greatest speed (conservative advancement), so that no contact is
// passed.

struct LiftTable {
  std::vector<double> y, m;

  explicit LiftTable(std::vector<double> values) : y(std::move(values)), m(y.size(), 0.0) {
    const std::size_t n = y.size();
    const double w = width();
    for (int pass = 0; pass < 80; ++pass)
      for (std::size_t i = 0; i < n; ++i) {
        const std::size_t a = (i + n - 1) % n, b = (i + 1) % n;
        m[i] = 0.25 * (6 * (y[a] - 2 * y[i] + y[b]) / (w * w) - m[a] - m[b]);
      }
  }
  double width() const { return 2 * M_PI / static_cast<double>(y.size()); }
  struct Value {
    double h, d1, d2;
  };
  Value at(double phi) const {
    const double w = width(), x = phi / w - std::floor(phi / (2 * M_PI)) * static_cast<double>(y.size());
    const std::size_t i = std::min(static_cast<std::size_t>(std::max(x, 0.0)), y.size() - 1),
                      k = (i + 1) % y.size();
    const double b = x - static_cast<double>(i), a = 1 - b;
    return {a * y[i] + b * y[k] + ((a * a * a - a) * m[i] + (b * b * b - b) * m[k]) * w * w / 6,
            (y[k] - y[i]) / w + ((1 - 3 * a * a) * m[i] + (3 * b * b - 1) * m[k]) * w / 6,
            a * m[i] + b * m[k]};
  }
};

struct CamFlight {
  LiftTable lift{{0, 0, 0}};
  double base = 1;             ///< m, base radius, of a roller's pitch curve with the roller's
  bool flat = false;           ///< else a roller
  double angle = 0, turn = 0;  ///< rad, rad/s, of the cam
  double face = 0, spin = 0;   ///< the same of a face's direction, whose left side is the cam's
  double x = 0, y = 0, vx = 0, vy = 0, ax = 0, ay = 0;

  /// Least and greatest radius of curvature of convex places, least of concave ones.
  struct Shape {
    double round = INFINITY, hollow = INFINITY, high = 0, steep = 0;
  };
  Shape shape() const {
    Shape s;
    const int n = 16 * static_cast<int>(lift.y.size());
    for (int i = 0; i < n; ++i) {
      const auto v = lift.at(2 * M_PI * i / n);
      const double r = base + v.h, square = r * r + v.d1 * v.d1;
      const double bend =
          flat ? 1 / (r + v.d2) : (r * r + 2 * v.d1 * v.d1 - r * v.d2) / (square * std::sqrt(square));
      if (bend > 0) s.round = std::min(s.round, 1 / bend);
      if (bend < 0) s.hollow = std::min(s.hollow, -1 / bend);
      s.high = std::max(s.high, r);
      s.steep = std::max(s.steep, std::abs(v.d1));
    }
    return s;
  }
  double gap(double t) const {
    const double cx = x + t * (vx + 0.5 * t * ax), cy = y + t * (vy + 0.5 * t * ay);
    if (flat) {
      const double f = face + spin * t;  // the axis; u = −perp axis
      return std::sin(f) * cx - std::cos(f) * cy - (base + lift.at(f - M_PI / 2 - angle - turn * t).h);
    }
    const double theta = angle + turn * t, co = std::cos(theta), si = std::sin(theta);
    return distance(co * cx + si * cy, co * cy - si * cx);
  }
  /// Distance of a point to the pitch curve, negative within it.
  double distance(double cx, double cy) const {
    const int n = 4 * static_cast<int>(lift.y.size());
    if (points.empty())
      for (int i = 0; i < n; ++i) {
        const double phi = 2 * M_PI * i / n, r = base + lift.at(phi).h;
        points.push_back({r * std::cos(phi), r * std::sin(phi)});
      }
    double least = INFINITY;
    int at = 0;
    for (int i = 0; i < n; ++i) {
      const double dx = cx - points[i].x, dy = cy - points[i].y, square = dx * dx + dy * dy;
      if (square < least) least = square, at = i;
    }
    const auto apart = [&](double phi) {
      const double r = base + lift.at(phi).h;
      return std::hypot(cx - r * std::cos(phi), cy - r * std::sin(phi));
    };
    double a = 2 * M_PI * (at - 1) / n, b = 2 * M_PI * (at + 1) / n;
    for (int i = 0; i < 45; ++i) {
      const double p = a + 0.381966 * (b - a), q = b - 0.381966 * (b - a);
      if (apart(p) < apart(q))
        b = q;
      else
        a = p;
    }
    const double d = apart(0.5 * (a + b)), polar = std::atan2(cy, cx);
    return std::hypot(cx, cy) < base + lift.at(polar).h ? -d : d;
  }
  struct Onset {
    double t, approach, fastest;  ///< s; m/s, 0 if it grazes; m/s, bound on its approach
  };
  /// The first contact until `end`, if any.
  std::optional<Onset> onset(double end) const {
    const auto s = shape();
    // greatest speed of approach from t to t + ahead
    const double ahead = 0.01 * end, pull = std::hypot(ax, ay);
    const auto fastest = [&](double t) {
      const double v = std::hypot(vx + ax * t, vy + ay * t) + pull * ahead,
                   far = std::hypot(x + t * (vx + 0.5 * t * ax), y + t * (vy + 0.5 * t * ay)) + v * ahead;
      return v + (flat ? far * std::abs(spin) + s.steep * std::abs(turn - spin) : far * std::abs(turn));
    };
    const double close = 1e-9 * base;
    double t = 0;
    for (double g = gap(0); g > close; g = gap(t)) {
      t += std::min(g / fastest(t), ahead);
      if (t > end) return std::nullopt;
    }
    const double fast = fastest(t);
    const double h = std::max(1e-7 * base / fast, 1e-9 * end);
    const double rate = (gap(t + h) - gap(t - h)) / (2 * h);
    double a = t, b = t + std::max(4 * close / std::max(-rate, 1e-9 * fast), h);
    if (!(gap(b) < 0)) return Onset{t, 0, fast};  // grazes
    bisect(a, b, 60, [&](double x) { return gap(x) > 0; });
    return Onset{a, -rate, fast};
  }

 private:
  struct Point {
    double x, y;
  };
  mutable std::vector<Point> points;
};

}  // namespace freeplay::reference
