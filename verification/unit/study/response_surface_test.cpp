// Response surfaces of the calibration, each against a closed form: scatter of starts, surfaces of
// functions that are not quadratic and their errors, and predictions.
#include "study/calibration/calibrate.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;

namespace {

/// Values of a function of ξ at the points, with normal noise.
template <class Function>
Eigen::VectorXd outcomes_at(const Eigen::MatrixXd& points, const Function& y, double deviation = 0,
                            unsigned seed = 5) {
  std::mt19937_64 engine(seed);
  std::normal_distribution<double> noise;
  Eigen::VectorXd outcomes(points.rows());
  for (Eigen::Index i = 0; i < points.rows(); ++i)
    outcomes[i] = y(points.row(i).transpose()) + deviation * noise(engine);
  return outcomes;
}

Eigen::VectorXd at(double x) { return Eigen::VectorXd::Constant(1, x); }

/// The difference quotient of a surface along the last unknown.
double slope(const ResponseSurface& surface, Eigen::VectorXd xi, double step) {
  const double here = surface(xi);
  xi[xi.size() - 1] += step;
  return (surface(xi) - here) / step;
}

}  // namespace

TEST_CASE("scatter of starts: the pooled relative covariance, weighted by distance", "[calibrate]") {
  // Two starts at 1 ± a and 1 ± b of one sign: r = ±a, ±b, so W = 2aa, 2ab, 2bb of one degree of
  // freedom; ρ = 1 is not reduced.
  Scatter scatter;
  CHECK_FALSE(scatter.known());
  Eigen::MatrixXd outcomes(2, 2);
  outcomes << 3 * 1.1, 5 * 1.2, 3 * 0.9, 5 * 0.8;
  const auto here = at(-0.5), there = at(0.5);
  scatter.add(here, outcomes);
  auto w = scatter.at(there);
  CHECK(w.freedom == Approx(1));
  CHECK(w.covariance(0, 0) == Approx(2 * 0.01));
  CHECK(w.covariance(1, 1) == Approx(2 * 0.04));
  CHECK(w.covariance(0, 1) == Approx(2 * 0.02));
  // A point without scatter at a distance of 1 = 2h has the weight e^(−2) here, and the inverse
  // ratio there.
  scatter.add(there, outcomes.row(0).replicate(2, 1));
  const double far = std::exp(-2.0);
  CHECK(scatter.at(here).covariance(0, 0) == Approx(2 * 0.01 / (1 + far)));
  CHECK(scatter.at(there).covariance(0, 0) == Approx(2 * 0.01 * far / (1 + far)));
  CHECK(scatter.at(here).freedom == Approx((1 + far) * (1 + far) / (1 + far * far)));
}

TEST_CASE("response surfaces: exact for quadratics, with a correct estimate of noise", "[calibrate]") {
  const auto points = space_filling(3, 60);
  CHECK(points.minCoeff() >= -1);
  CHECK(points.maxCoeff() <= 1);
  const auto f = [](const Eigen::VectorXd& x) {
    return 1 + 2 * x[0] - x[1] + 0.5 * x[0] * x[2] - 3 * x[2] * x[2];
  };
  const ResponseSurface exact(points, outcomes_at(points, f));
  CHECK(exact.error() < 1e-12);
  const Eigen::Vector3d here(0.3, -0.7, 0.2);
  CHECK(exact(here) == Approx(f(here)));
  CHECK(exact.gradient(here)[2] == Approx(0.5 * 0.3 - 6 * 0.2));
  // Noise of standard deviation s: the leave-one-out error is s√(1 + h/(1−h)), some 10 % above s
  // for 10 of 60.
  const ResponseSurface noisy(points, outcomes_at(points, f, 0.2, 3));
  CHECK(noisy.error() > 0.2 * 0.8);
  CHECK(noisy.error() < 0.2 * 1.45);
}

TEST_CASE("a response surface follows a function that is not quadratic and estimates its error",
          "[calibrate]") {
  // A step of width 0.2 with noise of 0.03. The error of a quadratic is 0.3; the surface must be
  // within four of its own standard errors everywhere, and these within a third of that.
  const auto y = [](const Eigen::VectorXd& xi) { return std::tanh(5 * xi[0]); };
  const auto points = space_filling(1, 40);
  const ResponseSurface surface(points, outcomes_at(points, y, 0.03));
  CHECK(surface.error() < 0.1);
  for (double x = -1; x <= 1; x += 0.05) {
    const auto xi = at(x);
    const double error = std::sqrt(surface.variance(xi));
    CAPTURE(x, surface(xi), y(xi), error);
    CHECK(std::abs(surface(xi) - y(xi)) < 4 * error);
    CHECK(error < 0.1);
    CHECK(surface.gradient(xi)[0] == Approx(slope(surface, xi, 1e-6)).margin(1e-3));
  }
}

TEST_CASE("the misfit does not depend on how well a surface is known", "[calibrate]") {
  // Runs on the right half alone. f − rᵀV⁻¹r − w|ξ|² is the determinant of the measurement's uncertainty, the
  // same on both sides. With the error of the surface in it, places without runs were worse by ln(1 + s²/U).
  const Eigen::MatrixXd points = Eigen::VectorXd::LinSpaced(30, 0, 1);
  const auto sine = [](const Eigen::VectorXd& xi) { return std::sin(6 * xi[0]); };
  const ResponseSurface surface(points, outcomes_at(points, sine, 0.01, 3));
  const Misfit misfit({{surface, 0, 0.01, {}, 0, 0, 0}}, {{}});
  const auto determinant = [&](double x) {
    const auto place = misfit.at(at(x), {true});
    return place.value - place.squares - Misfit::pull * x * x;
  };
  REQUIRE(surface.variance(at(-0.5)) > 100 * surface.variance(at(0.5)));
  CHECK(determinant(-0.5) == Approx(determinant(0.5)));
  CHECK(determinant(0.5) == Approx(std::log(surface.noise() + 1e-4)));
}

TEST_CASE("the error of a surface does not exceed the spread of smooth outcomes", "[calibrate]") {
  // Noise of very different size: the explicit inverse of an ill-conditioned K gave errors of up to
  // 0.024, three times the spread.
  const auto points = space_filling(2, 120);
  const auto smooth = [](const Eigen::VectorXd& xi) { return 0.01 * std::sin(2 * xi[0] + xi[1]); };
  Eigen::VectorXd noise = Eigen::VectorXd::Constant(120, 1e-3);
  for (const int i : {0, 40, 80}) noise[i] = 40;
  const ResponseSurface surface(points, outcomes_at(points, smooth), noise);
  for (double x = -1; x <= 1; x += 0.25)
    for (double y = -1; y <= 1; y += 0.25)
      CHECK(std::sqrt(surface.variance(Eigen::Vector2d(x, y))) < surface.spread());
}

TEST_CASE("scatter that varies over the ranges is not averaged over them", "[calibrate]") {
  // Deviations of 0.2 for ξ₁ < −0.6 and 0.001 elsewhere, 40 points of two starts. With smoothing
  // over ½√2, W was 0.065 to 0.069 in the middle. With a width of a fifth,
  // exp(−½(0.6/0.14)²) = 1e-4 of the chaotic part remains there, whose variance is 40,000 times as
  // great: at most 0.01 in the middle; and in the chaotic part a factor of 2, the accuracy of its
  // eight points.
  std::mt19937_64 engine(11);
  std::normal_distribution<double> normal;
  Scatter scatter;
  const auto points = space_filling(2, 40);
  for (int p = 0; p < 40; ++p) {
    const double size = points(p, 0) < -0.6 ? 0.2 : 0.001;
    Eigen::MatrixXd outcomes(2, 1);
    for (int s = 0; s < 2; ++s) outcomes(s, 0) = 1 + size * normal(engine);
    scatter.add(points.row(p).transpose(), outcomes);
  }
  scatter.choose_widths();
  CHECK(scatter.widths()[0] < 0.5 * scatter.widths()[1]);
  for (const double y : {-0.5, 0.0, 0.5}) {
    CHECK(std::sqrt(scatter.at(Eigen::Vector2d(0, y)).covariance(0, 0)) < 0.01);
    const double rough = std::sqrt(scatter.at(Eigen::Vector2d(-0.9, y)).covariance(0, 0));
    CHECK(rough > 0.1);
    CHECK(rough < 0.4);
  }
}

TEST_CASE("a response surface with a steep corner estimates its error in the gentle part", "[calibrate]") {
  // y = 0.1ξ₁ + 2.5 exp(−(ξ₂ + 1)/0.15)(1 − 0.3ξ₁), noise of 0.005: like peaks of a rig that grow
  // towards the least friction. Without a warp the error in the gentle half ξ₂ > 0 was 0.016 to
  // 0.098, and at 36 of 3,200 places more than four of the surface's own standard errors. The error
  // in the gentle half must be below six times the noise, and at one place in 1,000 it may exceed
  // four standard errors (errors of neighbouring places are correlated).
  const auto y = [](const Eigen::VectorXd& x) {
    return 0.1 * x[0] + 2.5 * std::exp(-(x[1] + 1) / 0.15) * (1 - 0.3 * x[0]);
  };
  const auto points = space_filling(2, 40);
  const auto places = space_filling(2, 400);
  int beyond = 0;
  for (const unsigned seed : {1u, 2u, 3u, 4u, 5u, 6u, 7u, 8u}) {
    CAPTURE(seed);
    const ResponseSurface surface(points, outcomes_at(points, y, 0.005, seed));
    CHECK(surface.warps()[1] > 0);
    double worst = 0;
    for (int i = 0; i < 400; ++i) {
      const Eigen::VectorXd xi = places.row(i).transpose();
      const double off = std::abs(surface(xi) - y(xi));
      beyond += off > 4 * std::sqrt(surface.variance(xi));
      if (xi[1] > 0) worst = std::max(worst, off);
    }
    CHECK(worst < 0.03);
    const Eigen::Vector2d here(0.3, -0.7);
    CHECK(surface.gradient(here)[1] == Approx(slope(surface, here, 1e-6)).epsilon(1e-3));
  }
  CHECK(beyond <= 3);
}

TEST_CASE("a response surface of a function with kinks and jumps estimates its error", "[calibrate]") {
  // |sin 12ξ|, and a step of 0.3 every 0.23, without noise, from 60 places. Errors in units of the
  // surface's own standard error: of 400 places, at most 5 % beyond three (normal: 0.3 %; the
  // errors at a kink or a jump are not normal, and neighbouring places are correlated), and the
  // root mean square at most 1.5.
  const auto kinks = [](double x) { return std::abs(std::sin(12 * x)); };
  const auto jumps = [](double x) { return 0.3 * std::floor(x / 0.23); };
  const auto points = space_filling(1, 60);
  for (const auto& y : {std::function<double(double)>(kinks), std::function<double(double)>(jumps)}) {
    const ResponseSurface surface(
        points, outcomes_at(points, [&](const Eigen::VectorXd& xi) { return y(xi[0]); }), {}, 0);
    int beyond = 0;
    double squares = 0;
    for (int i = 0; i < 400; ++i) {
      const double x = -0.99 + 1.98 * i / 399;
      const auto xi = at(x);
      const double z = (surface(xi) - y(x)) / std::sqrt(surface.variance(xi));
      beyond += std::abs(z) > 3;
      squares += z * z / 400;
      CHECK(surface.gradient(xi)[0] == Approx(slope(surface, xi, 1e-7)).epsilon(1e-2).margin(1e-2));
    }
    CAPTURE(beyond, squares);
    CHECK(beyond <= 20);
    CHECK(squares < 1.5 * 1.5);
  }
}

TEST_CASE("predictions hold while outcomes lie within their 95 % intervals as often as these promise",
          "[calibrate]") {
  // Of 12 outcomes, 4 outside an interval of 95 % have the probability Σ_{k≥4} C(12,k) 0.05^k
  // 0.95^(12−k) = 0.0022, and 3 that of 0.0196.
  std::vector<Forecast> forecasts(12, {0.5, 4});
  std::vector<double> outcomes(12, 0.5 + 2 * 1.95);
  CHECK(predictions_hold(forecasts, outcomes));
  for (const std::size_t k : {0u, 1u, 2u}) outcomes[k] = 0.5 - 2 * 1.97;
  CHECK(predictions_hold(forecasts, outcomes));
  outcomes[3] = 0.5 + 2 * 1.97;
  CHECK_FALSE(predictions_hold(forecasts, outcomes));
  // Runs that failed test nothing: 3 of 3 remain.
  for (std::size_t k = 3; k < 12; ++k) outcomes[k] = std::nan("");
  CHECK_FALSE(predictions_hold(forecasts, outcomes));
  CHECK(predictions_hold({}, {}));
}
