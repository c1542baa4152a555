#include "dynamics/profile_pair.hpp"

#include <numbers>

#include "numerics/descent.hpp"

namespace freeplay {
namespace {

/// rad: half width below which an interval is not divided further. The bound on G is then off by the square
/// of this width, 1e-10 of κ.
constexpr double least_half_width = 1e-5;
/// Within the reach the least G is exact to rounding. Farther away an error of this share of the excess is
/// allowed, because G may be level there.
constexpr double far_share = 1e-6;

}  // namespace

struct ProfilePair::Search {
  const ProfilePair& pair;
  const Vec2& d;
  double angle, far;  // far: |d|
  Place best;

  /// Bound of |G‴| from a to b.
  double greatest_third(double a, double b) const {
    const double of_bearing = pair.arc.on_journal ? angle : 0, of_journal = pair.arc.on_journal ? 0 : -angle;
    return pair.bearing().third(a + of_bearing, b + of_bearing) +
           pair.journal().third(a + of_journal, b + of_journal) + far;
  }

  void within(double a, double b) {
    const double m = 0.5 * (a + b), w = 0.5 * (b - a), third = greatest_third(a, b);
    const Place x = pair.look(d, angle, m);
    if (x.gap < best.gap) best = x;
    if (std::abs(x.slope) > (std::abs(x.bend) + 0.5 * third * w) * w) return;  // monotone
    const double least_bend = x.bend - third * w;
    const double lower = least_bend > 0 ? -0.5 * x.slope * x.slope / least_bend
                                        : -std::abs(x.slope) * w + 0.5 * least_bend * w * w;
    const double margin = 1e-15 * pair.clearance + far_share * std::max(0.0, best.gap - pair.reach());
    if (x.gap + lower > best.gap - margin) return;
    if (least_bend > 0 || w < least_half_width) {
      const Place end = pair.descend(d, angle, x, a, b);
      if (end.gap <= best.gap) best = end;
      return;
    }
    within(a, m);
    within(m, b);
  }
};

/// The minimum of G in [a, b].
ProfilePair::Place ProfilePair::descend(const Vec2& d, double angle, Place x, double a, double b) const {
  return freeplay::descend<&Place::slope>(x, a, b, 1e-10, [&](double to) { return look(d, angle, to); });
}

ProfilePair::Place ProfilePair::nearest(const Vec2& d, double angle) const {
  const double far = d.norm(), pi = std::numbers::pi;
  double psi = far > 0 ? std::atan2(d.y(), d.x()) : 0, a = psi - pi, b = psi + pi;
  Search search{*this, d, angle, far, {}};
  if (arc.whole) {
    search.best = look(d, angle, psi);
    // A circle with the least radius of curvature w₀ of C rolls within C (Blaschke). The one that touches where G
    // is stationary and less than w₀ leaves d no nearer place: this is the least G.
    if (const Place x = descend(d, angle, search.best, psi - 0.5 * pi, psi + 0.5 * pi);
        x.gap < 0.99 * arc.least && std::abs(x.slope) <= 1e-9 * x.bend)
      return x;
  } else {
    a = arc.from, b = arc.to;
    psi += 2 * pi * std::round((0.5 * (a + b) - psi) / (2 * pi));
    search.best = look(d, angle, std::clamp(psi, a, b));
    // Ends at which G increases into the arc. At a cut exactly one of both pairs has an end.
    Place first = look(d, angle, a), last = look(d, angle, b);
    first.end = first.slope >= 0, last.end = last.slope < 0;
    for (const auto& x : {first, last})
      if (x.gap < search.best.gap || (x.end && x.gap <= search.best.gap)) search.best = x;
  }
  if (!std::isfinite(search.best.gap)) return search.best;
  // G ≥ c + least p − |d| cos(φ − ψ)
  const double floor = clearance + bearing().bounds().low - journal().bounds().high;
  const double cosine = far > 0 ? (floor - search.best.gap) / far : -1;
  if (cosine > 0) {
    const double wide = (1 + 1e-9) * std::acos(std::min(cosine, 1.0)) + 1e-7;
    a = std::max(a, psi - wide), b = std::min(b, psi + wide);
  }
  if (a < b) search.within(a, b);
  auto& best = search.best;  // not stationary yet where a bound excluded its interval
  if (!best.end && best.slope != 0)
    best = arc.whole ? descend(d, angle, best, best.phi - pi, best.phi + pi)
                     : descend(d, angle, best, arc.from, arc.to);
  if (!arc.whole && !best.end)
    best.end = (best.phi == arc.from && best.slope > 0) || (best.phi == arc.to && best.slope < 0);
  return best;
}

GapMotion ProfilePair::motion(const MotionBounds& bounds, const Vec2& d) const {
  auto m = relative_motion(link, bounds);
  const auto of = [](const std::vector<double>& x, int body) { return omega(x.data(), body); };
  const double wi = of(bounds.speed, link.i), wj = of(bounds.speed, link.j);
  const double ai = of(bounds.acceleration, link.i), aj = of(bounds.acceleration, link.j);
  const auto &b = bearing().bounds(), &j = journal().bounds();
  const double speed = m.speed, s = speed + b.d2 * wi + j.d2 * wj;
  m.shape = GapMotion::Shape::curved;
  m.reach = reach();
  m.speed += b.d1 * wi + j.d1 * wj;
  m.acceleration += b.d1 * ai + j.d1 * aj + b.d2 * wi * wi + j.d2 * wj * wj + s * s / m.reach;
  if (arc.whole) return m;
  const double far = d.norm() + speed * bounds.duration, steep = b.d1 + j.d1 + far;
  const double w = of(bounds.speed, frame());
  m.speed += steep * w;
  m.acceleration += steep * of(bounds.acceleration, frame()) + (b.d2 + j.d2) * (wi + wj) * (wi + wj) +
                    2 * w * speed + w * w * far;
  return m;
}

}  // namespace freeplay
