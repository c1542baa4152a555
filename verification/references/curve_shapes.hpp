// Curves y(x) with their first two derivatives, evaluated from their definitions:
//
//     ramp        y = from + (to − from) p(s), s = (x − start)/rise,
//                 p = 10 s³ − 15 s⁴ + 6 s⁵ or s − sin(2πs)/(2π)
//     rise, dwell, return, rest: a ramp, a dwell, the ramp back, a rest; once or periodic
//     harmonic    y = mean + amplitude sin(2π x/period + phase)
//     table       straight lines, or the cubic spline with flat, free (y″ = 0) or periodic
//                 ends, from its moments M_i = y″(x_i):
//                 h_{i−1} M_{i−1} + 2 (h_{i−1} + h_i) M_i + h_i M_{i+1} = 6 (d_i − d_{i−1}),
//                 d_i = (y_{i+1} − y_i)/h_i
//
// Tables are constant beyond their ends, or repeat; a table whose end is `gain` above its beginning
// continues from there.
// Source: de Boor, A Practical Guide to Splines, ch. IV, for the moments. Units: those of x and y.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <utility>
#include <vector>

#include "verification/references/numerics.hpp"

namespace freeplay::reference {

/// y, y′, y″.
struct CurvePoint {
  double y = 0, slope = 0, bend = 0;
};

struct CurveShape {
  enum class Kind { constant, ramp, rise_dwell_return, harmonic, lines, spline };
  enum class Ends { flat, free };
  Kind kind = Kind::constant;
  double from = 0, to = 0, start = 0, rise = 1, dwell = 0, fall = 1, rest = 0;
  bool cycloidal = false, repeats = false;
  double mean = 0, amplitude = 0, period = 1, phase = 0;
  std::vector<std::pair<double, double>> points = {};
  Ends ends = Ends::free;  ///< of a spline that does not repeat
  std::vector<double> moments = {};

  /// Solves for a spline's moments; to be called once the points are set.
  void prepare() {
    if (kind != Kind::spline) return;
    const std::size_t n = points.size();
    std::vector<std::vector<double>> a(n, std::vector<double>(n, 0));
    moments.assign(n, 0);
    const auto h = [&](std::size_t i) { return points[i + 1].first - points[i].first; };
    const auto d = [&](std::size_t i) { return (points[i + 1].second - points[i].second) / h(i); };
    for (std::size_t i = 1; i + 1 < n; ++i) {
      a[i][i - 1] = h(i - 1), a[i][i] = 2 * (h(i - 1) + h(i)), a[i][i + 1] = h(i);
      moments[i] = 6 * (d(i) - d(i - 1));
    }
    if (repeats) {
      a[0][0] = 1, a[0][n - 1] = -1;
      a[n - 1][0] = 2 * h(0), a[n - 1][1] = h(0);
      a[n - 1][n - 2] += h(n - 2), a[n - 1][n - 1] += 2 * h(n - 2);
      moments[n - 1] = 6 * (d(0) - d(n - 2));
    } else if (ends == Ends::flat) {
      a[0][0] = 2 * h(0), a[0][1] = h(0), moments[0] = 6 * d(0);
      a[n - 1][n - 1] = 2 * h(n - 2), a[n - 1][n - 2] = h(n - 2), moments[n - 1] = -6 * d(n - 2);
    } else {
      a[0][0] = a[n - 1][n - 1] = 1;
    }
    eliminate(a, moments);
  }

  CurvePoint at(double x) const {
    switch (kind) {
      case Kind::constant:
        return {from, 0, 0};
      case Kind::ramp:
        return ramp(x - start, rise, from, to);
      case Kind::rise_dwell_return: {
        double u = x - start;
        const double length = rise + dwell + fall + rest;
        if (repeats) u -= length * std::floor(u / length);
        if (u < rise + dwell) return ramp(u, rise, from, to);
        return ramp(u - rise - dwell, fall, to, from);
      }
      case Kind::harmonic: {
        const double w = 2 * std::numbers::pi / period, a = w * x + phase;
        return {mean + amplitude * std::sin(a), amplitude * w * std::cos(a),
                -amplitude * w * w * std::sin(a)};
      }
      case Kind::lines:
      case Kind::spline:
        break;
    }
    double above = 0;
    if (repeats) {
      const double length = points.back().first - points.front().first;
      const double turns = std::floor((x - points.front().first) / length);
      x -= turns * length;
      above = turns * (points.back().second - points.front().second);
    }
    if (x <= points.front().first && !repeats) return {points.front().second, 0, 0};
    if (x >= points.back().first && !repeats) return {points.back().second, 0, 0};
    std::size_t i = 0;
    while (i + 2 < points.size() && points[i + 1].first <= x) ++i;
    const auto [x0, y0] = points[i];
    const auto [x1, y1] = points[i + 1];
    const double h = x1 - x0;
    if (kind == Kind::lines) return {above + y0 + (y1 - y0) * (x - x0) / h, (y1 - y0) / h, 0};
    const double m0 = moments[i], m1 = moments[i + 1], b = x - x0, c = x1 - x;
    return {above + m0 * c * c * c / (6 * h) + m1 * b * b * b / (6 * h) + (y0 / h - m0 * h / 6) * c +
                (y1 / h - m1 * h / 6) * b,
            -m0 * c * c / (2 * h) + m1 * b * b / (2 * h) + (y1 - y0) / h - (m1 - m0) * h / 6,
            (m0 * c + m1 * b) / h};
  }

  /// Points between a and b at which pieces meet, increasing, without the ends.
  std::vector<double> kinks(double a, double b) const {
    std::vector<double> own;
    double length = 0;
    if (kind == Kind::ramp) own = {start, start + rise};
    if (kind == Kind::rise_dwell_return) {
      own = {start, start + rise, start + rise + dwell, start + rise + dwell + fall};
      length = rise + dwell + fall + rest;
    }
    if (kind == Kind::lines || kind == Kind::spline) {
      for (const auto& p : points) own.push_back(p.first);
      length = points.back().first - points.front().first;
    }
    std::vector<double> list;
    if (repeats && length > 0) {
      for (double turn = std::floor((a - own.front()) / length); own.front() + turn * length < b; ++turn)
        for (const double k : own) list.push_back(k + turn * length);
    } else {
      list = own;
    }
    std::erase_if(list, [&](double k) { return !(k > a && k < b); });
    std::sort(list.begin(), list.end());
    return list;
  }

  /// ∫ y from a to b: Gauss–Legendre with five points on parts between kinks, each at most `part`
  /// long.
  double integral(double a, double b, double part) const {
    static constexpr double at[] = {0, 0.538469310105683091, 0.906179845938663993};
    static constexpr double weight[] = {128.0 / 225, 0.478628670499366468, 0.236926885056189088};
    if (b < a) return -integral(b, a, part);
    double sum = 0, from_here = a;
    auto ends_of = kinks(a, b);
    ends_of.push_back(b);
    for (const double end : ends_of) {
      const auto n = static_cast<long>(std::ceil((end - from_here) / part));
      for (long i = 0; i < n; ++i) {
        const double half = 0.5 * (end - from_here) / static_cast<double>(n);
        const double middle = from_here + (2 * static_cast<double>(i) + 1) * half;
        double s = weight[0] * this->at(middle).y;
        for (int k = 1; k < 3; ++k)
          s += weight[k] * (this->at(middle - half * at[k]).y + this->at(middle + half * at[k]).y);
        sum += half * s;
      }
      from_here = end;
    }
    return sum;
  }

 private:
  CurvePoint ramp(double u, double length, double a, double b) const {
    const double s = std::clamp(u / length, 0.0, 1.0), d = b - a;
    if (cycloidal) {
      const double w = 2 * std::numbers::pi;
      return {a + d * (s - std::sin(w * s) / w), d / length * (1 - std::cos(w * s)),
              d / (length * length) * w * std::sin(w * s)};
    }
    return {a + d * s * s * s * (10 + s * (-15 + 6 * s)), d / length * 30 * s * s * (1 - s) * (1 - s),
            d / (length * length) * 60 * s * (1 - s) * (1 - 2 * s)};
  }
};

}  // namespace freeplay::reference
