#include "dynamics/cam_pairs.hpp"

#include "numerics/descent.hpp"

namespace freeplay {
namespace {

/// rad: after a Newton step of this length, the next one is below rounding.
constexpr double last_step = 1e-10;
/// rad: half width below which an interval is not divided further. The bound on F is then off by the
/// square of this width, 1e-10 of F''.
constexpr double finest = 1e-5;

Vec2 radial_at(double phi) { return {std::cos(phi), std::sin(phi)}; }

}  // namespace

/// State of the second stage.
struct PitchCurve::Search {
  const PitchCurve& curve;
  Vec2 c;
  double rho;
  Place best;

  /// Lower bound of F over radii from `low` to `high` at angles from c of which the least has the
  /// cosine x/ρ: half the square of the distance to a ray at that angle.
  double bound(double x, double low, double high) const {
    const double off = std::clamp(x, low, high) - x;
    return 0.5 * (off * off + std::max(0.0, rho * rho - x * x));
  }
  void within(const Sector& s, double a, double b) {
    const double m = 0.5 * (a + b), w = 0.5 * (b - a);
    const Place x = curve.look(c, m, radial_at(m));
    if (x.half_square < best.half_square) best = x;
    const double far = std::sqrt(2 * x.half_square) + (s.high + s.d1) * w;
    const double third = 3 * s.d1 * s.d2 + far * (s.d3 + 3 * s.d2 + s.high) + 3 * s.d1 * rho;
    if (std::abs(x.rate) > (std::abs(x.bend) + third * w) * w) return;  // monotone
    const double least_bend = x.bend - third * w;
    const double least = least_bend > 0 ? -0.5 * x.rate * x.rate / least_bend
                                        : -std::abs(x.rate) * w + 0.5 * least_bend * w * w;
    if (x.half_square + least > best.half_square) return;
    if (least_bend > 0 || w < finest) {
      const Place end = curve.descend(c, x, a, b);
      if (end.half_square <= best.half_square) best = end;
      return;
    }
    within(s, a, m);
    within(s, m, b);
  }
  void run() {
    const auto& list = curve.sectors_;
    const std::size_t n = list.size();
    const double first = list.front().begin;
    const double phi = best.phi - CamProfile::turn * std::floor((best.phi - first) / CamProfile::turn);
    const std::size_t home = interval_of(n - 1, phi, [&](std::size_t k) { return list[k + 1].begin; });
    within(list[home], list[home].begin, list[home].end);
    for (const bool up : {true, false})
      for (std::size_t k = 1; k < n; ++k) {
        const auto& s = list[(up ? home + k : home + n - k) % n];
        const double x0 = dot(c, s.first), x1 = dot(c, s.last);
        if (bound(up ? x0 : x1, curve.low_, curve.high_) > best.half_square) break;
        if (bound(std::max(x0, x1), s.low, s.high) <= best.half_square) within(s, s.begin, s.end);
      }
  }
};

PitchCurve::PitchCurve(double offset, CamProfile profile) : offset_(offset), profile_(std::move(profile)) {
  profile_.each([&](double phi, const CamProfile::Value& y) {
    const double r = offset + y.h, d1 = std::abs(y.d1), d2 = std::abs(y.d2), d3 = std::abs(y.d3);
    if (sectors_.empty() || !(phi - sectors_.back().end > 1e-13)) {  // a piece begins where the last ends
      sectors_.push_back({phi, phi, 0, radial_at(phi), {}, r, r, d1, d2, d3});
      return;
    }
    auto& s = sectors_.back();
    s.spacing = phi - s.end;
    s.end = phi;
    s.low = std::min(s.low, r), s.high = std::max(s.high, r);
    s.d1 = std::max(s.d1, d1), s.d2 = std::max(s.d2, d2), s.d3 = std::max(s.d3, d3);
  });
  // Between samples, half a spacing times the next derivative. The third one is constant on pieces of a
  // spline and changes by less than 1 % of its greatest value between the 1024 samples of other pieces.
  low_ = INFINITY;
  for (auto& s : sectors_) {
    s.last = radial_at(s.end);
    s.d3 *= 1.01;
    s.d2 += 0.5 * s.spacing * s.d3;
    s.d1 += 0.5 * s.spacing * s.d2;
    s.low -= 0.5 * s.spacing * s.d1;
    s.high += 0.5 * s.spacing * s.d1;
    low_ = std::min(low_, s.low);
    high_ = std::max(high_, s.high);
  }
}

PitchCurve::Place PitchCurve::look(const Vec2& c, double phi, const Vec2& radial) const {
  Place x;
  x.phi = phi;
  x.lift = profile_.at(phi);
  x.radial = radial;
  const double r = offset_ + x.lift.h;
  const Vec2 round = perp(radial);
  x.slope = x.lift.d1 * radial + r * round;
  x.curl = (x.lift.d2 - r) * radial + 2 * x.lift.d1 * round;
  x.away = c - r * radial;
  x.half_square = 0.5 * x.away.squared_norm();
  x.rate = -dot(x.away, x.slope);
  x.bend = dot(x.slope, x.slope) - dot(x.away, x.curl);
  return x;
}

/// The minimum of F in [a, b].
PitchCurve::Place PitchCurve::descend(const Vec2& c, const Place& from, double a, double b) const {
  return freeplay::descend<&Place::rate>(from, a, b, last_step,
                                         [&](double to) { return look(c, to, radial_at(to)); });
}

/// The first stage; `delta` becomes Δ.
bool PitchCurve::only_minimum(double rho, double half_square, double& delta) const {
  const double apart = std::max({0.0, rho - high_, low_ - rho});
  const double less = (2 * half_square - apart * apart) / (2 * rho * low_);  // 1 − cos Δ
  if (!(less < 0.5)) return false;
  // Δ² ≤ 2.2 (1 − cos Δ) up to Δ = 1.05; cos Δ ≥ 1 − Δ²/2, sin Δ ≤ Δ.
  const double square = 2.2 * std::max(less, 0.0), d1 = profile_.bounds().d1;
  delta = std::sqrt(square);
  // F'' = r'² − 2r'ρ sin δ + rρ cos δ + r''(r − ρ cos δ) at the angle δ from c
  const double across = rho * delta;
  const double off = std::sqrt(2 * half_square) + d1 * delta + 0.5 * rho * square;
  return low_ * rho * (1 - 0.5 * square) > std::min(across, 2 * d1) * across + profile_.bounds().d2 * off;
}

PitchCurve::Place PitchCurve::nearest(const Vec2& c) const {
  const double rho = c.norm(), phi = std::atan2(c.y(), c.x());
  const Place x = look(c, phi, rho > 0 ? Vec2{c.x() / rho, c.y() / rho} : Vec2{1, 0});
  if (!std::isfinite(x.half_square)) return x;
  double delta = 0;
  if (only_minimum(rho, x.half_square, delta)) return descend(c, x, phi - delta, phi + delta);
  Search search{*this, c, rho, x};
  search.run();
  return search.best;
}

}  // namespace freeplay
