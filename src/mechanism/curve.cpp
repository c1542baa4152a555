#include "mechanism/curve.hpp"

#include "mechanism/piecewise.hpp"

#include <fmt/format.h>

#include <numbers>

namespace freeplay {
namespace {

using Stretch = Piecewise::Stretch;

Stretch level(double begin, double y) {
  Stretch s;
  s.begin = s.origin = begin;
  s.c[0] = y;
  return s;
}

Stretch rising(double begin, double length, double from, double to, Curve::Profile profile) {
  auto s = level(begin, from);
  const double d = to - from, L = length;
  if (profile == Curve::Profile::polynomial) {
    s.c[3] = 10 * d / (L * L * L);
    s.c[4] = -15 * d / (L * L * L * L);
    s.c[5] = 6 * d / (L * L * L * L * L);
  } else {
    s.c[1] = d / L;
    s.amplitude = -d / (2 * std::numbers::pi);
    s.rate = 2 * std::numbers::pi / L;
  }
  return s;
}

Piecewise tabulated(const Curve& c, Curve::Use use) {
  const auto& p = c.points;
  std::vector<Stretch> list;
  std::vector<double> slopes;
  if (c.between == Curve::Between::spline)
    slopes = spline_slopes(p, c.repeats                  ? SplineEnds::periodic
                              : use == Curve::Use::place ? SplineEnds::flat
                                                         : SplineEnds::natural);
  if (!c.repeats) list.push_back(level(p.front().first, p.front().second));
  for (std::size_t i = 0; i + 1 < p.size(); ++i) {
    auto s = level(p[i].first, p[i].second);
    const double h = p[i + 1].first - p[i].first, d = p[i + 1].second - p[i].second;
    if (slopes.empty()) {
      s.c[1] = d / h;
    } else {
      const double a = slopes[i], b = slopes[i + 1];
      s.c[1] = a;
      s.c[2] = (3 * d - h * (2 * a + b)) / (h * h);
      s.c[3] = (h * (a + b) - 2 * d) / (h * h * h);
    }
    list.push_back(s);
  }
  if (!c.repeats) {
    list.push_back(level(p.back().first, p.back().second));
    return Piecewise(list);
  }
  return Piecewise(list, p.back().first - p.front().first, p.back().second - p.front().second);
}

}  // namespace

Piecewise Curve::lay(Use use) const {
  switch (shape) {
    case Shape::constant:
      return Piecewise({level(0, value)});
    case Shape::ramp:
      return Piecewise({level(start, from), rising(start, rise, from, to, profile), level(start + rise, to)});
    case Shape::rise_dwell_return: {
      const double back = start + rise + dwell, end = back + fall;
      std::vector<Stretch> list{rising(start, rise, from, to, profile)};
      if (!repeats) list.insert(list.begin(), level(start, from));
      if (dwell > 0) list.push_back(level(start + rise, to));
      list.push_back(rising(back, fall, to, from, profile));
      if (!repeats || rest > 0) list.push_back(level(end, from));
      return Piecewise(list, repeats ? end + rest - start : 0);
    }
    case Shape::harmonic: {
      auto s = level(0, mean);
      s.amplitude = amplitude;
      s.rate = 2 * std::numbers::pi / period;
      s.phase = phase;
      return Piecewise({s});
    }
    case Shape::table:
      return tabulated(*this, use);
  }
  return Piecewise();
}

std::string Curve::refusal(Use use) const {
  if (shape != Shape::table) return "";
  const auto course = lay(use);
  const auto most = course.greatest();
  if (repeats && use != Use::place && points.front().second != points.back().second)
    return fmt::format("is periodic but begins at {1:.6g} and ends at {0:.6g}; use equal values at both ends",
                       points.back().second, points.front().second);
  if (use != Use::place) return "";
  for (const double knot : course.knots())
    if (course.jump(knot).slope > 1e-9 * most.slope)
      return fmt::format(
          "has a kink at x = {:.6g}, where a prescribed position would have a jump in speed; use between = "
          "\"spline\", or prescribe the velocity",
          knot);
  return "";
}

Piecewise CurveOr::lay(const std::vector<Curve>& curves, Curve::Use use) const {
  if (curve >= 0) return curves[static_cast<std::size_t>(curve)].lay(use);
  Piecewise::Stretch s;
  s.c[0] = constant;
  return Piecewise({s});
}

}  // namespace freeplay
