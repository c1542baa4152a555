// Curves and splines against their definitions: shapes, derivatives, integrals and means.
#include <catch2/catch.hpp>

#include <cmath>

#include "mechanism/curve.hpp"
#include "mechanism/piecewise.hpp"

using namespace freeplay;

namespace {

Curve table(Curve::Points points, Curve::Between between, bool repeats = false) {
  Curve c;
  c.shape = Curve::Shape::table;
  c.points = std::move(points);
  c.between = between;
  c.repeats = repeats;
  return c;
}

}  // namespace

TEST_CASE("splines of each kind satisfy their definition", "[driving]") {
  SECTION("a clamped cubic is reproduced where its end slopes are zero") {
    // 3x² − 2x³ has slope 0 at 0 and 1.
    std::vector<std::pair<double, double>> knots;
    for (const double x : {0.0, 0.2, 0.3, 0.7, 1.0}) knots.emplace_back(x, x * x * (3 - 2 * x));
    const auto m = spline_slopes(knots, SplineEnds::flat);
    for (std::size_t i = 0; i < knots.size(); ++i)
      CHECK(m[i] == Approx(6 * knots[i].first * (1 - knots[i].first)).margin(1e-13));
  }
  SECTION("second derivatives are continuous, with the prescribed ends") {
    const Curve::Points points{{0, 1}, {0.4, -2}, {0.5, 3}, {1.1, 0}, {2, 1}};
    for (const bool repeats : {false, true}) {
      const auto y = table(points, Curve::Between::spline, repeats).lay();
      for (const double knot : y.knots()) {
        const auto jump = y.jump(knot);
        CHECK(jump.value < 1e-12);
        if (!repeats && (knot == 0 || knot == 2)) continue;  // continues with zero slope
        CHECK(jump.slope < 1e-11);
        CHECK(jump.bend < 1e-9);
      }
      if (!repeats) CHECK(std::abs(y.jet(0.0, 0.1).bend) < 1e-10);
    }
  }
  SECTION("periodic splines through two and three points") {
    for (const auto& points : {Curve::Points{{0, 1}, {2, 1}}, Curve::Points{{0, 0}, {1, 4}, {3, 0}}}) {
      const auto y = table(points, Curve::Between::spline, true).lay();
      for (const double knot : y.knots()) CHECK(y.jump(knot).bend < 1e-12);
      for (const auto& [x, value] : points) CHECK(y.value(x + 30) == Approx(value).margin(1e-12));
    }
  }
}

TEST_CASE("derivatives, integrals and means of every curve shape are consistent", "[driving]") {
  Curve ramp, cycle, wave;
  ramp.shape = Curve::Shape::ramp;
  ramp.from = 1, ramp.to = -3, ramp.start = 0.3, ramp.rise = 0.8;
  cycle.shape = Curve::Shape::rise_dwell_return;
  cycle.to = 2, cycle.start = -0.2, cycle.rise = 0.5, cycle.dwell = 0.2, cycle.fall = 0.7, cycle.rest = 0.3;
  cycle.profile = Curve::Profile::cycloidal;
  cycle.repeats = true;
  wave.shape = Curve::Shape::harmonic;
  wave.mean = 0.4, wave.amplitude = 2, wave.period = 0.9, wave.phase = 0.3;
  const auto points = Curve::Points{{-0.4, 1}, {0.4, -2}, {0.5, 3}, {1.1, 1}};
  for (const auto& curve :
       {ramp, cycle, wave, table(points, Curve::Between::linear, true), table(points, Curve::Between::spline),
        table(points, Curve::Between::spline, true)}) {
    CAPTURE(curve.what());
    const auto y = curve.lay();
    const auto F = y.antiderivative(0.2, 7);
    CHECK(F.value(0.2) == Approx(7));
    for (const double x : {-3.3, -0.35, 0.1, 0.47, 0.9, 2.9, 12.6}) {
      const double d = 1e-5;
      const auto jet = y.jet(x);
      CHECK(jet.value == Approx(y.value(x)).margin(1e-12));
      CHECK(jet.slope == Approx((y.value(x + d) - y.value(x - d)) / (2 * d)).margin(1e-5));
      CHECK(jet.bend == Approx((y.jet(x + d).slope - y.jet(x - d).slope) / (2 * d)).margin(1e-3));
      CHECK(F.jet(x).slope == Approx(y.value(x)).margin(1e-10));
      // Over several periods, and by the midpoint rule.
      CHECK(y.integral(x, x + 4.7) == Approx(F.value(x + 4.7) - F.value(x)).margin(1e-9));
      double sum = 0;
      for (int i = 0; i < 20000; ++i) sum += y.value(x + (i + 0.5) * 1.3 / 20000);
      CHECK(y.mean(x, x + 1.3) == Approx(sum / 20000).margin(1e-6));
      const double knot = y.next_knot(x);
      CHECK(knot > x);
      CHECK((knot == INFINITY || y.next_knot(knot) > knot));
    }
  }
}

TEST_CASE("a pulse between the samples of a step is included in the mean", "[driving]") {
  const auto y =
      table({{0, 0}, {0.5, 0}, {0.5 + 1e-6, 1e6}, {0.5 + 2e-6, 0}, {1, 0}}, Curve::Between::linear).lay();
  CHECK(y.mean(0.4, 0.6) == Approx(5).epsilon(1e-6));
  CHECK(y.greatest().value == Approx(1e6).epsilon(0.05));
}

TEST_CASE("a mean over a short interval keeps full precision", "[driving]") {
  // f and its mean over x ± d differ by f″d²/6 < 1e-15 here; the error of a difference of two
  // integrals was 1e-16/d.
  Curve sine;
  sine.shape = Curve::Shape::harmonic;
  sine.amplitude = 2, sine.period = 0.7, sine.phase = 0.4, sine.mean = 0.3;
  Curve hump;
  hump.shape = Curve::Shape::rise_dwell_return;
  hump.to = 3, hump.rise = 0.5, hump.fall = 0.6, hump.repeats = true;
  const double d = 1e-9;
  for (const auto& y : {sine.lay(), hump.lay(), table({{-1, -50}, {1, 50}}, Curve::Between::linear).lay()})
    for (const double x : {0.03, 0.31, 0.77}) {
      CHECK(y.mean(x - d, x + d) == Approx(y.value(x)).epsilon(1e-14));
      CHECK(y.mean(x + d, x - d) == y.mean(x - d, x + d));
    }
  // Over longer intervals it is the mean of two halves, across knots and periods too.
  for (const auto& y : {sine.lay(), hump.lay()})
    CHECK(y.mean(0.1, 5.1) == Approx(0.5 * (y.mean(0.1, 2.6) + y.mean(2.6, 5.1))).epsilon(1e-13));
  // 3-4-5: the integral over the whole rise is half of its length.
  CHECK(hump.lay().mean(0, 0.5) == Approx(1.5).epsilon(1e-14));
}
