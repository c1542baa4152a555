#include "analysis/attractor.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace freeplay {
namespace {

double less(double a, double b, double circle) { return circle > 0 ? std::remainder(a - b, circle) : a - b; }

/// Limit of a geometric sequence that contains a, b, c (Aitken's Δ²); c if it does not converge.
double limit(double a, double b, double c, double circle) {
  const double first = less(b, a, circle), second = less(c, b, circle);
  if (!(std::abs(second) < std::abs(first)) || first * second <= 0) return c;
  const double on = second * second / (first - second);
  return std::abs(on) <= 10 * std::abs(first + second) ? c + on : c;
}

/// Greatest difference of two points in a column, relative to its scale.
double distance(const double* a, const double* b, const std::vector<double>& scale,
                const Likeness& likeness) {
  double worst = 0;
  for (std::size_t j = 0; j < scale.size(); ++j) {
    const double d = std::abs(less(a[j], b[j], likeness.circles[j]));
    if (d == 0) continue;
    worst = std::max(worst, d / scale[j]);
    if (std::isnan(d)) return INFINITY;
  }
  return worst;
}

std::vector<double> scales(std::span<const double> rows, const Likeness& likeness) {
  const auto n = likeness.circles.size();
  std::vector<double> s(n, 0);
  for (std::size_t i = 0; i < rows.size(); ++i) s[i % n] = std::max(s[i % n], std::abs(rows[i]));
  for (std::size_t j = 0; j < n; ++j)
    if (likeness.circles[j] > 0) s[j] = 0.5 * likeness.circles[j];
  return s;
}

}  // namespace

std::string Attractor::name() const {
  if (period == none) return "no points";
  return period == aperiodic ? "aperiodic" : fmt::format("period {}", period);
}

Attractor attractor_of(std::span<const double> rows, const Likeness& likeness) {
  Attractor a;
  const auto width = likeness.circles.size(), count = rows.size() / width;
  if (count == 0) return a;
  a.scale = scales(rows, likeness);
  a.period = Attractor::aperiodic;
  const auto repeats = [&](std::size_t n) {
    for (std::size_t i = 0; i + n < count; ++i)
      if (!(distance(&rows[i * width], &rows[(i + n) * width], a.scale, likeness) <= likeness.tolerance))
        return false;
    return true;
  };
  for (std::size_t n = 1; n <= static_cast<std::size_t>(likeness.most) && 3 * n <= count; ++n)
    if (repeats(n)) {
      a.period = static_cast<int>(n);
      break;
    }
  const auto n = static_cast<std::size_t>(std::max(a.period, 1)), last = count - n;
  a.points.assign(rows.begin() + static_cast<std::ptrdiff_t>(last * width), rows.end());
  if (a.period == Attractor::aperiodic) return a;
  // From the first cycle to the middle one, and from there to the last.
  const std::size_t step = (count / n - 1) / 2 * n;
  for (std::size_t i = 0; i < n * width; ++i) {
    const auto at = [&](std::size_t back) { return rows[(last - back) * width + i]; };
    a.points[i] = limit(at(2 * step), at(step), at(0), likeness.circles[i % width]);
  }
  // Points that alternate about their limit with decreasing amplitude have a period that divides
  // the observed one.
  for (std::size_t part = 1; part < n; ++part) {
    if (n % part != 0) continue;
    bool repeats_sooner = true;
    for (std::size_t i = 0; i < n && repeats_sooner; ++i)
      repeats_sooner = distance(&a.points[i * width], &a.points[(i + part) % n * width], a.scale, likeness) <=
                       likeness.tolerance;
    if (!repeats_sooner) continue;
    a.period = static_cast<int>(part);
    a.points.erase(a.points.begin(), a.points.end() - static_cast<std::ptrdiff_t>(part * width));
    break;
  }
  return a;
}

bool same(const Attractor& a, const Attractor& b, const Likeness& likeness) {
  if (a.period != b.period) return false;
  if (a.period <= 0) return true;
  const auto width = likeness.circles.size(), n = static_cast<std::size_t>(a.period);
  std::vector<double> scale(width);
  for (std::size_t j = 0; j < width; ++j) scale[j] = std::max(a.scale[j], b.scale[j]);
  for (std::size_t shift = 0; shift < n; ++shift) {
    double worst = 0;
    for (std::size_t i = 0; i < n; ++i)
      worst = std::max(worst,
                       distance(&a.points[i * width], &b.points[(i + shift) % n * width], scale, likeness));
    if (worst <= 3 * likeness.tolerance) return true;
  }
  return false;
}

std::size_t place_among(std::vector<Attractor>& list, const Attractor& one, const Likeness& likeness) {
  const auto found =
      std::ranges::find_if(list, [&](const Attractor& other) { return same(one, other, likeness); });
  if (found != list.end()) return static_cast<std::size_t>(found - list.begin());
  list.push_back(one);
  return list.size() - 1;
}

}  // namespace freeplay
