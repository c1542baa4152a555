// Response surfaces of the calibration, each against a closed form: scatter of starts, surfaces of
// functions that are not quadratic and their errors, and predictions.
#include "study/calibration/calibrate.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;

TEST_CASE("scatter of starts: the pooled relative covariance, weighted by distance", "[calibrate]") {
  // Two starts at 1 ± a and 1 ± b of one sign: r = ±a, ±b, so W = 2aa, 2ab, 2bb of one degree of
  // freedom; ρ = 1 is not reduced.
  Scatter scatter;
  CHECK_FALSE(scatter.known());
  Eigen::MatrixXd outcomes(2, 2);
  outcomes << 3 * 1.1, 5 * 1.2, 3 * 0.9, 5 * 0.8;
  const Eigen::VectorXd here = Eigen::VectorXd::Constant(1, -0.5), there = Eigen::VectorXd::Constant(1, 0.5);
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

TEST_CASE("a response surface follows a function that is not quadratic and estimates its error",
          "[calibrate]") {
  // A step of width 0.2 with noise of 0.03. The error of a quadratic is 0.3; the surface must be
  // within four of its own standard errors everywhere, and these within a third of that.
  const auto y = [](double x) { return std::tanh(5 * x); };
  std::mt19937_64 engine(5);
  std::normal_distribution<double> noise(0, 0.03);
  const auto points = space_filling(1, 40);
  Eigen::VectorXd outcomes(40);
  for (int i = 0; i < 40; ++i) outcomes[i] = y(points(i, 0)) + noise(engine);
  const ResponseSurface surface(points, outcomes);
  CHECK(surface.error() < 0.1);
  for (double x = -1; x <= 1; x += 0.05) {
    const Eigen::VectorXd xi = Eigen::VectorXd::Constant(1, x);
    const double error = std::sqrt(surface.variance(xi));
    CAPTURE(x, surface(xi), y(x), error);
    CHECK(std::abs(surface(xi) - y(x)) < 4 * error);
    CHECK(error < 0.1);
    const Eigen::VectorXd beside = Eigen::VectorXd::Constant(1, x + 1e-6);
    CHECK(surface.gradient(xi)[0] == Approx((surface(beside) - surface(xi)) / 1e-6).margin(1e-3));
  }
}

TEST_CASE("the misfit does not depend on how well a surface is known", "[calibrate]") {
  // Runs on the right half alone. f − rᵀV⁻¹r − w|ξ|² is the determinant of the measurement's uncertainty, the
  // same on both sides. With the error of the surface in it, places without runs were worse by ln(1 + s²/U).
  Eigen::MatrixXd points(30, 1);
  Eigen::VectorXd outcomes(30);
  std::mt19937_64 engine(3);
  std::normal_distribution<double> noise(0, 0.01);
  for (int i = 0; i < 30; ++i) {
    points(i, 0) = i / 29.0;
    outcomes[i] = std::sin(6 * points(i, 0)) + noise(engine);
  }
  const ResponseSurface surface(points, outcomes);
  const Misfit misfit({{surface, 0, 0.01, {}, 0, 0, 0}}, {{}});
  const auto determinant = [&](double x) {
    const Eigen::VectorXd xi = Eigen::VectorXd::Constant(1, x);
    const auto at = misfit.at(xi, {true});
    return at.value - at.squares - Misfit::pull * x * x;
  };
  REQUIRE(surface.variance(Eigen::VectorXd::Constant(1, -0.5)) >
          100 * surface.variance(Eigen::VectorXd::Constant(1, 0.5)));
  CHECK(determinant(-0.5) == Approx(determinant(0.5)));
  CHECK(determinant(0.5) == Approx(std::log(surface.noise() + 1e-4)));
}

TEST_CASE("the error of a surface does not exceed the spread of smooth outcomes", "[calibrate]") {
  // Noise of very different size: the explicit inverse of an ill-conditioned K gave errors of up to
  // 0.024, three times the spread.
  const auto points = space_filling(2, 120);
  Eigen::VectorXd outcomes(120), noise(120);
  for (int i = 0; i < 120; ++i) {
    outcomes[i] = 0.01 * std::sin(2 * points(i, 0) + points(i, 1));
    noise[i] = i % 40 == 0 ? 40 : 1e-3;
  }
  const ResponseSurface surface(points, outcomes, noise);
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
    std::mt19937_64 engine(seed);
    std::normal_distribution<double> noise(0, 0.005);
    Eigen::VectorXd outcomes(40);
    for (int i = 0; i < 40; ++i) outcomes[i] = y(points.row(i).transpose()) + noise(engine);
    const ResponseSurface surface(points, outcomes);
    CHECK(surface.warps()[1] > 0);
    double worst = 0;
    for (int i = 0; i < 400; ++i) {
      const Eigen::VectorXd xi = places.row(i).transpose();
      const double off = std::abs(surface(xi) - y(xi));
      beyond += off > 4 * std::sqrt(surface.variance(xi));
      if (xi[1] > 0) worst = std::max(worst, off);
    }
    CHECK(worst < 0.03);
    const Eigen::Vector2d here(0.3, -0.7), beside(0.3, -0.7 + 1e-6);
    CHECK(surface.gradient(here)[1] == Approx((surface(beside) - surface(here)) / 1e-6).epsilon(1e-3));
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
    Eigen::VectorXd outcomes(60);
    for (int i = 0; i < 60; ++i) outcomes[i] = y(points(i, 0));
    const ResponseSurface surface(points, outcomes, {}, 0);
    int beyond = 0;
    double squares = 0;
    for (int i = 0; i < 400; ++i) {
      const double x = -0.99 + 1.98 * i / 399;
      const Eigen::VectorXd xi = Eigen::VectorXd::Constant(1, x);
      const double z = (surface(xi) - y(x)) / std::sqrt(surface.variance(xi));
      beyond += std::abs(z) > 3;
      squares += z * z / 400;
      const Eigen::VectorXd beside = Eigen::VectorXd::Constant(1, x + 1e-7);
      CHECK(surface.gradient(xi)[0] ==
            Approx((surface(beside) - surface(xi)) / 1e-7).epsilon(1e-2).margin(1e-2));
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
