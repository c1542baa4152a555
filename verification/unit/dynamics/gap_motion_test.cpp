// Bounds on a gap within a step, against the gap itself finely sampled, over random motions.
#include "dynamics/gap_motion.hpp"

#include <catch2/catch.hpp>

#include <cmath>
#include <random>

#include "formulations/integrators/crossing.hpp"

using namespace freeplay;

namespace {

/// Body 0 on the cubic through velocities and accelerations at both ends of [0, h], with an arm on
/// it, against the origin.
struct Path {
  double h = 1, q0[3], v0[3], a0[3], v1[3], a1[3], q1[3];
  Vec2 arm;

  explicit Path(std::mt19937_64& engine) {
    std::uniform_real_distribution<double> u(-1, 1);
    h = std::pow(10, 2 * u(engine) - 1);
    for (int i = 0; i < 3; ++i) {
      q0[i] = u(engine);
      v0[i] = 3 * u(engine);
      a0[i] = 10 * u(engine);
      v1[i] = 3 * u(engine);
      a1[i] = 10 * u(engine);
      q1[i] = position(i, h);
    }
    arm = {u(engine), u(engine)};
  }
  double rate(int i, double t) const {
    const double s = t / h, r = 1 - s;
    return r * r * (1 + 2 * s) * v0[i] + s * s * (3 - 2 * s) * v1[i] + h * s * r * (r * a0[i] - s * a1[i]);
  }
  /// The integral of rate(), polynomial by polynomial.
  double position(int i, double t) const {
    const double s = t / h, s2 = s * s, s3 = s2 * s, s4 = s3 * s;
    return q0[i] + h * (v0[i] * (s - s3 + 0.5 * s4) + v1[i] * (s3 - 0.5 * s4)) +
           h * h * (a0[i] * (0.5 * s2 - 2 * s3 / 3 + 0.25 * s4) - a1[i] * (s3 / 3 - 0.25 * s4));
  }
  /// From the arm's end to the origin, and its rate.
  std::pair<Vec2, Vec2> d(double t) const {
    const double c = std::cos(position(2, t)), n = std::sin(position(2, t)), w = rate(2, t);
    const Vec2 s{c * arm.x() - n * arm.y(), n * arm.x() + c * arm.y()};
    return {Vec2{-position(0, t) - s.x(), -position(1, t) - s.y()},
            Vec2{-rate(0, t) + w * s.y(), -rate(1, t) - w * s.x()}};
  }
};

Watched watched(const Path& p, const GapMotion& m, double t) {
  const auto [d, rate] = p.d(t);
  if (m.shape == GapMotion::Shape::straight) return {d.x() - m.rest, rate.x()};
  const double sign = m.shape == GapMotion::Shape::outside ? 1 : -1;
  return {sign * (d.norm() - m.rest), sign * dot(d, rate) / d.norm()};
}

GapMotion motion_of(const Path& p, GapMotion::Shape shape, double rest) {
  MotionBounds bounds;
  bounds.enclose(p.h, 3, p.q0, p.v0, p.a0, p.q1, p.v1, p.a1);
  auto m = relative_motion(Link{0, ground, p.arm, {0, 0}}, bounds);
  m.shape = shape;
  m.rest = rest;
  return m;
}

}  // namespace

TEST_CASE("bounds of a gap between two instants hold against its samples, over random motions", "[unseen]") {
  std::mt19937_64 engine(3);
  std::uniform_real_distribution<double> u(0, 1);
  using Shape = GapMotion::Shape;
  constexpr int cases = 3000;
  int risen = 0, fallen = 0, tight = 0;
  for (int i = 0; i < cases; ++i) {
    const Path path(engine);
    const auto shape = std::array{Shape::outside, Shape::inside, Shape::straight}[i % 3];
    const auto bounds = motion_of(path, shape, 0.1 + 2 * u(engine));
    // A part of the step, from all of it to a thousandth.
    const double width = path.h * std::pow(10, -3 * u(engine)), from = (path.h - width) * u(engine);
    const auto start = watched(path, bounds, from), end = watched(path, bounds, from + width);
    double least = std::min(start.value, end.value), slowest = INFINITY, fastest = -INFINITY;
    for (int k = 0; k <= 200; ++k) {
      const auto sample = watched(path, bounds, from + width * k / 200);
      least = std::min(least, sample.value);
      slowest = std::min(slowest, sample.rate);
      fastest = std::max(fastest, sample.rate);
    }
    const double bound = bounds.least(start, end, width);
    const bool rises = bounds.rises(start, end, width), falls = bounds.falls(start, end, width);
    CAPTURE(i, width, path.h, least, slowest, fastest);
    CHECK(bound <= least + 1e-12);  // rounding
    if (rises) CHECK(slowest > 0);
    if (falls) CHECK(fastest < 0);
    risen += rises;
    fallen += falls;
    tight += least - bound < 0.01;  // of gaps of the order of 1
  }
  // The bounds are useful: many parts have a proved direction, and many bounds are close to the gap.
  CHECK(risen > cases / 10);
  CHECK(fallen > cases / 10);
  CHECK(tight > cases / 4);
}

TEST_CASE("the first closing of a gap is found between ends at which it is open", "[unseen]") {
  double unseen = 0;
  const auto parabola = [](double depth, double width, double centre) {
    return [=](double t) {
      const double s = (t - centre) / width;
      return Watched{-depth + (1 + depth) * s * s, 2 * (1 + depth) * s / width};
    };
  };
  for (const double depth : {1e-12, 1e-6, 0.5})
    for (const double width : {1e-6, 1e-3, 0.3})
      for (const double centre : {0.1, 0.5, 0.777}) {
        const auto y = parabola(depth, width, centre);
        if (y(0).value <= 0) continue;
        const GapMotion m{GapMotion::Shape::straight, 0, 2 * (1 + depth) / (width * width), 0};
        const auto t = first_loss(y, 0, 1, y(0), y(1), m, 1e-16, unseen);
        CAPTURE(depth, width, centre);
        REQUIRE(t.has_value());
        // −depth + (1 + depth) s² = 0: the crossing, to √(rounding/depth) of its width.
        CHECK(*t == Approx(centre - width * std::sqrt(depth / (1 + depth))).margin(1e-9 * width + 1e-15));
      }
  const auto grazing = parabola(0, 0.2, 0.4);
  CHECK_FALSE(first_loss(grazing, 0, 1, grazing(0), grazing(1), {GapMotion::Shape::straight, 0, 50, 0}, 1e-15,
                         unseen));
  CHECK(unseen == 0);
  // With a bound that no piece can satisfy, 4096 places are evaluated, and this is reported.
  const GapMotion wild{GapMotion::Shape::straight, 0, 1e40, 0};
  CHECK_FALSE(first_loss(grazing, 0, 1, grazing(0), grazing(1), wild, 1e-15, unseen));
  CHECK(unseen == Approx(0.125e40 / 4096 / 4096).epsilon(0.01));
  // An infinite bound, as for teeth whose centres may come closer than the meshing distance, is no
  // reason for a report: 256 pieces decide.
  const GapMotion none{GapMotion::Shape::straight, 0, INFINITY, 0};
  unseen = 0;
  CHECK_FALSE(first_loss(grazing, 0, 1, grazing(0), grazing(1), none, 1e-15, unseen));
  const auto dip = parabola(0.5, 0.2, 0.4);
  const auto t = first_loss(dip, 0, 1, dip(0), dip(1), none, 1e-15, unseen);
  REQUIRE(t.has_value());
  CHECK(*t == Approx(0.4 - 0.2 * std::sqrt(0.5 / 1.5)).margin(1e-9));
  CHECK(unseen == 0);
}
