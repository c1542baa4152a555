// Location of the first sign change of a function within a step, on the dense output of the step.
// Instead of sampling, it uses rigorous bounds on the function between two times
// (dynamics/gap_motion.hpp) and halves the interval until they are conclusive. The penalty
// formulation, the event-driven scheme and adaptive time stepping use it to find contact events.
// first_loss() is the search, land_on_first() the repetition of a step that ends at its first
// event.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>

#include "dynamics/gap_motion.hpp"
#include "dynamics/planar.hpp"
#include "dynamics/system.hpp"
#include "numerics/bracketed_root.hpp"

namespace freeplay {

/// StepCourse: a scalar w(t) of the state, on the dense output of a step, with its rate and a bound of
/// its second derivative. Speeds and the demands of controllers contain velocities, whose second
/// derivatives no bound of the bodies' motion covers. w is therefore represented by its Chebyshev
/// interpolant of degree N = 8,
///
///     w = Σ c_k T_k(s),  s = 2 (t − t0)/h − 1,      |ẅ| ≤ (2/h)² Σ |c_k| k² (k² − 1)/3,
///
/// which is exact where the dense output is a polynomial (dopri5: degree 4, Hermite: 3) and w is
/// linear in the state. First crossings of a value follow by first_loss().
class StepCourse {
 public:
  static constexpr std::size_t degree = 8;
  /// Time of sample k = 0 to `degree` of a step from t0 to t1; the samples begin at t1.
  static double time(double t0, double t1, std::size_t k) {
    if (k == 0) return t1;
    return k == degree ? t0 : t0 + 0.5 * (t1 - t0) * (1 + nodes()[k]);
  }
  StepCourse() = default;
  /// `w`: the samples.
  StepCourse(double t0, double t1, const std::array<double, degree + 1>& w) : t0_(t0), t1_(t1) {
    const auto& node = nodes();
    for (std::size_t k = 0; k <= degree; ++k) {
      double sum = 0;
      for (std::size_t j = 0; j <= degree; ++j) {
        const std::size_t turn = (j * k) % (2 * degree);  // cos(π j k/N)
        const double cosine = turn <= degree ? node[turn] : node[2 * degree - turn];
        sum += (j == 0 || j == degree ? 0.5 : 1) * w[j] * cosine;
      }
      c_[k] = (k == 0 || k == degree ? 1.0 : 2.0) / degree * sum;
      largest_ = std::fmax(largest_, std::abs(w[k]));
    }
    const double per = 2 / (t1 - t0);
    for (std::size_t k = 2; k <= degree; ++k)
      acceleration_ += per * per * std::abs(c_[k]) * static_cast<double>(k * k * (k * k - 1)) / 3;
  }
  double acceleration() const { return acceleration_; }
  /// Greatest |w| of the samples.
  double largest() const { return largest_; }
  /// ẇ at t: Σ c_k k U_{k−1}(s) · 2/h.
  double rate(double t) const {
    const double s = std::fmin(1, std::fmax(-1, 2 * (t - t0_) / (t1_ - t0_) - 1));
    double before = 0, u = 1, sum = 0;
    for (std::size_t k = 1; k <= degree; ++k) {
      sum += static_cast<double>(k) * c_[k] * u;
      const double next = 2 * s * u - before;
      before = u;
      u = next;
    }
    return sum * 2 / (t1_ - t0_);
  }

 private:
  static const std::array<double, degree + 1>& nodes() {
    static const auto list = [] {
      std::array<double, degree + 1> x{};
      for (std::size_t k = 0; k <= degree; ++k)
        x[k] = std::cos(3.141592653589793 * static_cast<double>(k) / degree);
      return x;
    }();
    return list;
  }
  double t0_ = 0, t1_ = 0, acceleration_ = 0, largest_ = 0;
  std::array<double, degree + 1> c_{};
};

/// The longest step (s) for bodies that rotate: a cubic through the ends of the step may deviate
/// from a circular arc by no more than (0.3 rad)⁴/384 = 2e-5 of its radius. `v`: velocities of the
/// bodies.
inline double longest_step(const System& system, const double* v) {
  double omega = 0;
  if (system.contacts() == 0) return INFINITY;
  for (int b = 0; b < system.bodies(); ++b) omega = std::max(omega, std::abs(planar::rate(v, b)));
  return omega > 0 ? system.longest_turn() / omega : INFINITY;
}

/// Fraction of the clearance: a contact of rigid bodies found at a greater depth has been missed.
inline constexpr double too_deep = 1e-2;
/// Fraction of the clearance: possible depth of an undetected contact that needs no warning. A step
/// with a greater possible depth is repeated with half its length, up to `most_halvings` times; the
/// bound is proportional to the square of the step.
inline constexpr double seen_depth = 1e-6;
inline constexpr int most_halvings = 4;

/// First time in [t0, t1] at which `at`, which is positive while a mode lasts, becomes negative; t0
/// if it was never positive. `start` and `end` are its values at the ends, and `motion` bounds its
/// curvature between them. The interval is halved until each piece is proved to stay above −noise,
/// or to rise or fall monotonically. A piece too short for the resolution of time counts as
/// negative if its end is. If ten thousand pieces are not conclusive (the function is within
/// rounding of zero throughout, or its bounds are wide), the ends of 4096 pieces decide, and
/// `unseen` is raised to the possible depth between them.
template <class F>
std::optional<double> first_loss(F at, double t0, double t1, Watched start, const Watched& end,
                                 const GapMotion& motion, double noise, double& unseen) {
  // The bound, reduced by its own rounding error.
  const auto least_of = [&](const Watched& a, const Watched& b, double h) {
    const double terms = std::abs(a.value) + std::abs(b.value) +
                         (std::abs(a.rate) + std::abs(b.rate) + motion.acceleration * h) * h;
    return motion.least(a, b, h) - 4e-16 * terms;
  };
  if (least_of(start, end, t1 - t0) > -noise) return std::nullopt;
  if (start.value <= 8 * noise && start.rate > 0)
    start.value = std::max(start.value, 0.0);  // the mode has just changed here
  const auto value = [&](double t) { return at(t).value; };
  /// For a function that falls from a to b: first the quarter with the root, then the root.
  const auto root = [&](double ta, const Watched& a, double tb, const Watched& b) -> std::optional<double> {
    if (b.value >= 0) return std::nullopt;
    if (a.value <= 0) return ta;
    double from = ta, above = a.value;
    for (int quarter = 1; quarter < 4; ++quarter) {
      const double t = ta + (tb - ta) * quarter / 4, y = value(t);
      if (y < 0) return bracketed_root(value, from, t, above, y);
      if (y > 0) {
        from = t;
        above = y;
      }
    }
    return bracketed_root(value, from, tb, above, b.value);
  };
  int pieces = 10000;
  const auto search = [&](auto&& self, double ta, const Watched& a, double tb, const Watched& b,
                          int halvings) -> std::optional<double> {
    const double h = tb - ta, least = least_of(a, b, h);
    if (least > -noise || motion.rises(a, b, h)) return std::nullopt;
    if (motion.falls(a, b, h)) return root(ta, a, tb, b);
    const double tm = ta + 0.5 * h;
    if (halvings == 0 || pieces < 0 || !(tm > ta && tm < tb)) {
      if (halvings == 0) unseen = std::max(unseen, -least);
      return b.value < 0 ? std::optional(a.value > 0 ? tb : ta) : std::nullopt;
    }
    --pieces;
    const Watched m = at(tm);
    if (const auto t = self(self, ta, a, tm, m, halvings - 1)) return t;
    return self(self, tm, m, tb, b, halvings - 1);
  };
  if (!std::isfinite(motion.acceleration)) {
    // An infinite bound (wheels whose centres may come closer within the step than teeth mesh;
    // overflow) proves nothing: the ends of 256 pieces decide.
    Watched a = start;
    double ta = t0;
    for (int k = 1; k <= 256; ++k) {
      const double tb = k < 256 ? t0 + (t1 - t0) * k / 256 : t1;
      const Watched b = k < 256 ? at(tb) : end;
      if (b.value < 0)
        return a.value > 0 ? std::optional(bracketed_root(value, ta, tb, a.value, b.value)) : ta;
      a = b;
      ta = tb;
    }
    return std::nullopt;
  }
  const auto found = search(search, t0, start, t1, end, 60);
  if (pieces >= 0) return found;
  pieces = 10000;
  return search(search, t0, start, t1, end, 12);
}

/// Rounding error (m) of the gap of contact k, from the positions q.
inline double gap_rounding(const System& system, int k, const double* q) {
  const auto& facts = system.contact_facts(k);
  double reach = system.longest_arm();
  for (const int body : facts.bodies)
    if (body != ground) {
      const auto at = planar::position(q, body);
      reach += std::max(std::abs(at.x()), std::abs(at.y()));
    }
  return 1e-13 * facts.clearance + 4e-16 * reach;
}

/// Bound on the acceleration, within the last step of `method`, of a plane vector that is a linear
/// function `of` of the n coordinates. In the method's state, the coordinates come first, followed
/// by their rates. Like MethodState::enclose(), widened where the method's interpolant is not
/// cubic.
template <class Method, class F>
double acceleration_of(const Method& method, int n, F of, std::vector<double>& scratch) {
  const double h = method.t - method.t_old;
  const Vec2 q0 = of(method.x_old.data()), v0 = of(method.x_old.data() + n),
             a0 = of(method.dxdt_old.data() + n);
  const Vec2 q1 = of(method.x.data()), v1 = of(method.x.data() + n), a1 = of(method.dxdt.data() + n);
  std::array<double, 2> apart{0, 0};
  const int places = Method::cubic ? 1 : Method::long_steps ? 8 : 2;
  for (int k = 1; k < places; ++k) {
    const double s = static_cast<double>(k) / places, r = 1 - s;
    method.interpolate(method.t_old + s * h, scratch);
    const Vec2 off = of(scratch.data() + n) - r * r * (1 + 2 * s) * v0 - s * s * (3 - 2 * s) * v1 -
                     h * s * r * (r * a0 - s * a1);
    apart = {std::max(apart[0], std::abs(off.x())), std::max(apart[1], std::abs(off.y()))};
  }
  const double steep = (Method::long_steps ? 128 : 3.1) / h;
  const double x = cubic_bounds(h, q0.x(), v0.x(), a0.x(), q1.x(), v1.x(), a1.x()).acceleration,
               y = cubic_bounds(h, q0.y(), v0.y(), a0.y(), q1.y(), v1.y(), a1.y()).acceleration;
  return std::hypot(x + steep * apart[0], y + steep * apart[1]);
}

/// Bound on the curvature of the gap of contact k within the last step of `method`; `m` is the
/// bound from the separate motions of its two bodies. Without arms, only the relative motion of
/// their centres matters and, along a wall at rest, only its normal component (`normal()`): the gap
/// of discs that are in contact and fall together has no curvature.
template <class Method, class Normal>
GapMotion narrowed(GapMotion m, const System& system, int k, const Method& method, Normal normal,
                   std::vector<double>& scratch) {
  const auto [i, j] = system.contact_facts(k).bodies;
  const bool straight = m.shape == GapMotion::Shape::straight;
  if (system.longest_arm() > 0 || m.shape == GapMotion::Shape::curved || (straight && i != ground)) return m;
  if (straight) {
    const SparseRow across = normal();
    const auto of = [&](const double* y) { return Vec2{across.dot(y), 0.0}; };
    m.acceleration = std::min(m.acceleration, acceleration_of(method, system.n(), of, scratch));
    return m;
  }
  const auto of = [i = i, j = j](const double* y) { return centre(y, j) - centre(y, i); };
  m.acceleration = std::min(m.acceleration, acceleration_of(method, system.n(), of, scratch));
  return m;
}

/// Ends the last step of `method` at t; if that is its beginning, integration starts anew there.
template <class Method, class F>
void land_at(Method& method, F& f, double t) {
  if (t <= method.t_old)
    method.start(f, method.t_old, method.x_old);
  else
    method.land(f, t);
}

/// The same for a gap that reaches zero: Newton's method on `gap` (Watched) at the end of the step
/// corrects t, up to `rounding`.
template <class Method, class F, class Gap>
void land_on_gap(Method& method, F& f, double& t, double rounding, Gap gap) {
  if (t <= method.t_old) return land_at(method, f, t);
  for (int i = 0; i < 5; ++i) {
    method.land(f, t);
    const Watched end = gap();
    if (std::abs(end.value) <= rounding || end.rate == 0) return;
    const double next = t - end.value / end.rate;
    if (!(next > method.t_old) || std::abs(next - t) <= 2e-16 * t) return;
    if (std::abs(next - t) > 0.1 * (t - method.t_old)) return;  // grazing: keep the bracketed root
    t = next;
  }
}

/// Ends the last step of `method` at `first` by land(first). As long as the shorter step, which has
/// tighter bounds, shows that a gap closed earlier, it ends there instead. gaps() returns the first
/// closing of a gap in the present step, or an event at its end.
template <class Method, class Event, class Land, class Gaps>
void land_on_first(const Method& method, Event& first, Land land, Gaps gaps) {
  land(first);
  for (int tries = 0; tries < 20; ++tries) {
    const Event before = gaps(first);
    const double edge = 1e-6 * (method.t - method.t_old);
    if (!(before.t > method.t_old + edge && before.t < method.t - edge)) return;
    land(first = before);
  }
}

}  // namespace freeplay
