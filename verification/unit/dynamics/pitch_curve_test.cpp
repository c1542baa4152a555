// The nearest point of a pitch curve against brute force: waved and random tables, standard laws, points
// on the curve, near it, in hollows, far away and at the cam's centre.
#include "dynamics/cam_pairs.hpp"

#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

using namespace freeplay;

namespace {

/// The least distance among 20,000 points, refined by golden sections.
double least_distance(const PitchCurve& curve, const std::vector<Vec2>& points, const Vec2& c) {
  const auto n = points.size();
  std::size_t at = 0;
  for (std::size_t i = 0; i < n; ++i)
    if ((c - points[i]).squared_norm() < (c - points[at]).squared_norm()) at = i;
  const auto apart = [&](double phi) {
    const double r = curve.offset() + curve.profile().at(phi).h;
    return (c - Vec2{r * std::cos(phi), r * std::sin(phi)}).norm();
  };
  const double w = 2 * M_PI / static_cast<double>(n), middle = w * static_cast<double>(at);
  double a = middle - w, b = middle + w;
  for (int i = 0; i < 60; ++i) {
    const double p = a + 0.381966 * (b - a), q = b - 0.381966 * (b - a);
    if (apart(p) < apart(q))
      b = q;
    else
      a = p;
  }
  return std::min(apart(0.5 * (a + b)), (c - points[at]).norm());
}

/// Compares `count` curves; returns the number of points at which the program is farther away.
int compare(unsigned seed, int count, int points_each) {
  std::mt19937_64 engine(seed);
  const auto uniform = [&](double a, double b) { return std::uniform_real_distribution(a, b)(engine); };
  int wrong = 0;
  for (int i = 0; i < count; ++i) {
    CamProfile profile;
    std::vector<std::pair<double, double>> table;
    if (i % 3 == 0) {
      const int waves = std::uniform_int_distribution(3, 120)(engine), n = 24 * waves;
      const double high = uniform(0.002, 1.2) / waves, phase = uniform(0, 6);
      for (int k = 0; k < n; ++k)
        table.push_back({2 * M_PI * k / n, high * (1 + std::sin(2 * M_PI * k * waves / n + phase))});
      profile = CamProfile::through(table);
    } else if (i % 3 == 1) {
      const int n = std::uniform_int_distribution(3, 43)(engine);
      for (int k = 0; k < n; ++k)
        table.push_back({2 * M_PI * (k + uniform(-0.3, 0.3)) / n, uniform(0, 1.5 / n)});
      profile = CamProfile::through(table);
    } else {
      profile = CamProfile::standard(static_cast<CamLaw>(i / 3 % 3), uniform(0.05, 0.8), uniform(0, 6),
                                     uniform(0.3, 2), uniform(0, 1), uniform(0.3, 2));
    }
    const PitchCurve curve(1, profile);
    std::vector<Vec2> points;
    for (int k = 0; k < 20000; ++k) {
      const double phi = 2 * M_PI * k / 20000, r = 1 + profile.at(phi).h;
      points.push_back({r * std::cos(phi), r * std::sin(phi)});
    }
    for (int k = 0; k < points_each; ++k) {
      const double to = uniform(-7, 7), on = 1 + profile.at(to).h;
      const double sizes[] = {uniform(-0.5, 3), uniform(-1e-3, 1e-3), uniform(-0.1, 0.3),
                              uniform(-1e-7, 1e-7)};
      const double r = on + sizes[k % 4];
      if (!(r > 0)) continue;
      const Vec2 c{r * std::cos(to), r * std::sin(to)};
      const auto found = curve.nearest(c);
      const double truth = least_distance(curve, points, c), gap = found.gap();
      // Rounding of positions.
      const bool right =
          std::abs(std::abs(gap) - truth) <= 1e-14 * (1 + r) && (truth < 1e-14 || (gap < 0) == (r < on));
      if (!right) {
        UNSCOPED_INFO("curve " << i << ", point " << k << ": " << gap << " for " << truth);
        ++wrong;
      }
    }
  }
  return wrong;
}

}  // namespace

TEST_CASE("the nearest point of a pitch curve is nearest over the whole curve", "[cam]") {
  CHECK(compare(6201, 24, 40) == 0);
}

TEST_CASE("the nearest points of 1,000 curves of two seeds are nearest over the whole curve",
          "[cam][.long]") {
  CHECK(compare(620101, 1000, 40) == 0);
  CHECK(compare(620102, 1000, 40) == 0);
}

TEST_CASE("a pitch curve's nearest point to the cam's centre ends", "[cam]") {
  const PitchCurve curve(1, CamProfile::standard(CamLaw::cycloidal, 0.5, 0.4, 1.9, 0.4, 2.2));
  CHECK(std::abs(curve.nearest({0, 0}).gap()) == Approx(1).margin(1e-9));
}
