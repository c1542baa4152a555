// Parts of the calibration, each against a closed form: scatter, surfaces of functions that are not
// quadratic, correlated targets, open intervals, identifiability. By the command: a rejected fit
// has no interval.
#include <boost/math/distributions/students_t.hpp>
#include <tuple>

#include "measure/alignment.hpp"
#include "study/calibration/calibrate.hpp"
#include "study/runs/case_run.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;
using Catch::Matchers::Contains;

namespace {

/// Quadratics without noise: the surface is exact, and its error is zero.
ResponseSurface exact(int unknowns, const std::function<double(const Eigen::VectorXd&)>& y) {
  const auto points = space_filling(unknowns, 30);
  Eigen::VectorXd outcomes(30);
  for (int i = 0; i < 30; ++i) outcomes[i] = y(points.row(i).transpose());
  return {points, outcomes};
}

const std::vector<Unknown> one{{"a", "a", "", -1, 1, false}};

std::string head(const std::string& scene) {
  return fmt::format(
      "scene = \"{}\"\njoint = \"gudgeon\"\naccelerometer = \"accelerometer\"\nrevolutions = 1\ndiscard = 0.5\n"
      "starts = 2\n",
      scene);
}
std::string guide() { return (test::source_folder() / "cases/flores2011-experiment/guide.toml").string(); }

}  // namespace

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
  // Noise of very different size: the explicit inverse of an ill-conditioned K gave errors of up to 0.024, three
  // times the spread.
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
  // |sin 12ξ|, and a step of 0.3 every 0.23, without noise, from 60 places. Errors in units of the surface's own
  // standard error: of 400 places, at most 5 % beyond three (normal: 0.3 %; the errors at a kink or a jump are
  // not normal, and neighbouring places are correlated), and the root mean square at most 1.5.
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
  // Of 12 outcomes, 4 outside an interval of 95 % have the probability Σ_{k≥4} C(12,k) 0.05^k 0.95^(12−k) = 0.0022,
  // and 3 that of 0.0196.
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

TEST_CASE("a ridge names the combination of unknowns that the targets determine", "[calibrate]") {
  // ln a and ln b in −1 … 1; the target ln a − 2 ln b = 0 ± 0.05 determines b²/a. Along the ridge a passes its
  // range and b ∝ √a; for a known a, ln b is known to 1.96·0.025.
  const std::vector<Unknown> two{{"a", "a", "", std::exp(-1.0), std::exp(1.0), true},
                                 {"b", "b", "", std::exp(-1.0), std::exp(1.0), true}};
  const auto both = exact(2, [](const Eigen::VectorXd& xi) { return xi[0] - 2 * xi[1]; });
  const Misfit misfit({{both, 0, 0.05, {}, 0, 0, 0}}, {{}});
  const auto found = ridge_of(misfit, fit(misfit, {true}, two), two);
  REQUIRE(found);
  CHECK(found->along == 0);
  CHECK(found->powers_of);
  CHECK(found->slope[1] == Approx(0.5).epsilon(1e-3));
  CHECK(found->follows[1]);
  CHECK(found->within[1] == Approx(std::expm1(1.96 * 0.025)).epsilon(1e-2));
  CHECK(found->ends[0][0] == Approx(std::exp(-1.0)).epsilon(1e-6));
  CHECK(found->ends[1][1] == Approx(std::exp(0.5)).epsilon(1e-3));
  // With another combination as a second target there is none.
  const auto other = exact(2, [](const Eigen::VectorXd& xi) { return xi[0] + xi[1]; });
  const Misfit apart({{both, 0, 0.05, {}, 0, 0, 0}, {other, 0, 0.05, {}, 1, 0, 1}}, {{}, {}});
  CHECK_FALSE(ridge_of(apart, fit(apart, {true, true}, two), two));
}

TEST_CASE("identifiability includes places that the targets cannot tell apart", "[calibrate]") {
  // y = ξ² ± 0.02: the linear interval at ξ is 1.96·0.02/(2|ξ|), but −ξ meets the target as well. Half the
  // distance between both is |ξ|, 0.5 in the median of the range.
  const auto bowl = exact(1, [](const Eigen::VectorXd& xi) { return xi[0] * xi[0]; });
  const auto seen = identifiability(Misfit({{bowl, 0, 0.02, {}, 0, 0, 0}}, {{}}), space_filling(1, 31));
  CHECK(seen.left_open[0] > 0.45);
  CHECK(seen.left_open[0] < 0.6);
}

TEST_CASE("correlated targets carry no more information than their correlation allows", "[calibrate]") {
  // Two statistics y = bξ of the same runs whose scatter has the same variance w and correlation ρ:
  // the information is
  // 2b²/(w (1 + ρ)), and the interval half t/√(that + pull). Treated as independent they give an
  // interval narrower by √(1 + ρ).
  const double b = 0.7;
  std::mt19937_64 engine(7);
  std::normal_distribution<double> normal;
  Scatter scatter;
  for (int p = 0; p < 50; ++p) {
    Eigen::MatrixXd outcomes(4, 2);
    for (int s = 0; s < 4; ++s) {
      const double common = normal(engine);
      outcomes(s, 0) = 1 + 0.05 * (common + 0.3 * normal(engine));
      outcomes(s, 1) = 1 + 0.05 * (common + 0.3 * normal(engine));
    }
    scatter.add(Eigen::VectorXd::Zero(1), outcomes);
  }
  const auto local = scatter.at(Eigen::VectorXd::Zero(1));
  const auto surface = exact(1, [&](const Eigen::VectorXd& xi) { return b * xi[0]; });
  const Misfit misfit({{surface, 0, 1e-6, {}, 0, 0, 0}, {surface, 0, 1e-6, {}, 0, 1, 0}}, {scatter});
  const auto f = fit(misfit, {true, true}, one);
  const Eigen::Vector2d g(b, b);
  const double information = g.dot(local.covariance.inverse() * g) + Misfit::pull;
  const double t = boost::math::quantile(boost::math::students_t(local.freedom), 0.975);
  CHECK(local.freedom == Approx(150));
  CHECK(f.unknowns[0].high == Approx(t / std::sqrt(information)).epsilon(1e-3));
  CHECK(f.unknowns[0].low == Approx(-t / std::sqrt(information)).epsilon(1e-3));
  // As if they were independent measurements: two of variance w.
  const Misfit apart({{surface, 0, 1e-6, {}, 0, 0, 0}, {surface, 0, 1e-6, {}, 1, 1, 1}}, {scatter, scatter});
  CHECK(fit(apart, {true, true}, one).unknowns[0].high < 0.8 * f.unknowns[0].high);
  // A measurement that is the mean of four segments has half the uncertainty.
  const Misfit longer({{surface, 0, 1e-6, {4, 1}, 0, 0, 0}, {surface, 0, 1e-6, {4, 1}, 0, 1, 0}}, {scatter});
  CHECK(fit(longer, {true, true}, one).unknowns[0].high ==
        Approx(t / std::sqrt(4 * (information - Misfit::pull) + Misfit::pull)).epsilon(1e-3));
}

TEST_CASE("a confidence interval at a limit of its range is open there, and spans two minima",
          "[calibrate]") {
  // y = ξ measured as 0.9 ± 0.2: the lower end of the profile is 1.96·0.2 below 0.9, the upper one
  // is the end of the range.
  const auto line = exact(1, [](const Eigen::VectorXd& xi) { return xi[0]; });
  const double w = Misfit::pull, s = 0.2, best = 0.9 / (1 + w * s * s),
               half = 1.959964 / std::sqrt(1 / (s * s) + w);
  const auto f = fit(Misfit({{line, 0.9, s, {}, 0, 0, 0}}, {{}}), {true}, one);
  CHECK(f.unknowns[0].low == Approx(best - half).epsilon(1e-4));
  CHECK_FALSE(f.unknowns[0].open_low);
  CHECK(f.unknowns[0].high == 1);
  CHECK(f.unknowns[0].open_high);
  // y = ξ² measured as 0.49 ± 0.05: ξ = ±√(0.49 ± 0.098), both signs.
  const auto bowl = exact(1, [](const Eigen::VectorXd& xi) { return xi[0] * xi[0]; });
  const auto both = fit(Misfit({{bowl, 0.49, 0.05, {}, 0, 0, 0}}, {{}}), {true}, one);
  CHECK(both.unknowns[0].low == Approx(-std::sqrt(0.49 + 0.098)).epsilon(2e-3));
  CHECK(both.unknowns[0].high == Approx(std::sqrt(0.49 + 0.098)).epsilon(2e-3));
  CHECK_FALSE(both.unknowns[0].open_low);
}

TEST_CASE("identifiability: parameters without influence, and joint influence of targets", "[calibrate]") {
  const auto points = space_filling(2, 30);
  const std::vector<Scatter> none(2);
  // Both targets depend on ξ₁ alone.
  const auto first = exact(2, [](const Eigen::VectorXd& xi) { return xi[0]; });
  const auto blind =
      identifiability(Misfit({{first, 0, 0.1, {}, 0, 0, 0}, {first, 0, 0.1, {}, 1, 0, 1}}, none), points);
  CHECK(blind.identified(0));
  CHECK_FALSE(blind.identified(1));
  CHECK(blind.sensitivity(0, 0) == Approx(10).epsilon(1e-6));
  CHECK(blind.sensitivity(0, 1) == Approx(0).margin(1e-6));
  CHECK(blind.left_open[0] == Approx(1.96 / std::sqrt(2 * 100 + Misfit::pull)).epsilon(1e-6));
  // Both depend on the sum: each parameter is open, and their correlation is −1 except for the
  // pull.
  const auto sum = exact(2, [](const Eigen::VectorXd& xi) { return xi[0] + xi[1]; });
  const auto together =
      identifiability(Misfit({{sum, 0, 0.1, {}, 0, 0, 0}, {sum, 0, 0.1, {}, 1, 0, 1}}, none), points);
  CHECK_FALSE(together.identified(0));
  CHECK_FALSE(together.identified(1));
  CHECK(together.correlation(0, 1) < -0.99);
  // The sum and the difference: both are identified.
  const auto difference = exact(2, [](const Eigen::VectorXd& xi) { return xi[0] - xi[1]; });
  const auto seen =
      identifiability(Misfit({{sum, 0, 0.1, {}, 0, 0, 0}, {difference, 0, 0.1, {}, 1, 0, 1}}, none), points);
  CHECK(seen.identified(0));
  CHECK(seen.identified(1));
  CHECK(seen.correlation(0, 1) == Approx(0).margin(1e-6));
}

TEST_CASE("contradicting targets are rejected", "[calibrate]") {
  // y = ξ twice, measured as ±0.5 to 0.1: the middle differs by five standard deviations from each,
  // χ² = 50 for one degree of freedom.
  const auto line = exact(1, [](const Eigen::VectorXd& xi) { return xi[0]; });
  const std::vector<Scatter> none(2);
  const auto off =
      fit(Misfit({{line, 0.5, 0.1, {}, 0, 0, 0}, {line, -0.5, 0.1, {}, 1, 0, 1}}, none), {true, true}, one);
  CHECK(off.squares == Approx(50).epsilon(1e-3));
  CHECK(off.degrees == 1);
  CHECK(off.rejected);
  CHECK_FALSE(off.holds());
  const auto on =
      fit(Misfit({{line, 0.1, 0.1, {}, 0, 0, 0}, {line, -0.1, 0.1, {}, 1, 0, 1}}, none), {true, true}, one);
  CHECK_FALSE(on.rejected);
}

TEST_CASE("a long measured file is divided into segments of the length of a run", "[calibrate][study]") {
  // The peak of revolution k is 100 + k: of 12 revolutions in segments of 5 the greatest are 104
  // and 109, the expectation of runs of 5; the greatest of all, 111, is not.
  test::TemporaryFolder folder;
  std::string csv = "t,acceleration,uncertainty\n";
  const double turn = 60.0 / 200;
  for (int i = 0; i < 12 * 600; ++i) {
    const int number = i / 600;
    csv += fmt::format("{},{},0.25\n", i * turn / 600,
                       i % 600 == 77 ? 100 + number : 20 * std::cos(2 * std::numbers::pi * i / 600));
  }
  write_file(folder.path() / "data.csv", csv);
  const auto study = [&](int revolutions) {
    write_file(
        folder.path() / "study.toml",
        head(guide()) + fmt::format("[calibrate]\npoints = 5\nrevolutions = {}\n[calibrate.unknowns.c]\n"
                                    "key = \"joints.gudgeon.clearance\"\nlow = 0.2e-3\nhigh = 1e-3\n"
                                    "[calibrate.targets.t]\nstatistic = \"peak_max\"\ndata = \"data.csv\"\n",
                                    revolutions));
    return plan_calibration(read_study(folder.path() / "study.toml"), {});
  };
  const auto five = study(5);
  CHECK(five.measured[0] == Approx(106.5));
  CHECK(five.targets[0].turns == 5);
  CHECK(five.targets[0].stretches.count == 2);
  CHECK(five.targets[0].noise == Approx(0.25));
  CHECK(five.study.variants[0].revolutions == 5);
  CHECK(five.study.variants[0].noise == Approx(0.25));
  // Runs longer than the file are shortened to it.
  const auto all = study(40);
  CHECK(all.measured[0] == Approx(111));
  CHECK(all.targets[0].stretches.count == 1);
  CHECK(all.study.variants[0].revolutions == 12);
}

TEST_CASE("a waveform is the difference of the mean revolutions of a run and of its file",
          "[calibrate][waveform][study]") {
  test::TemporaryFolder folder;
  std::string csv = "crank_angle,acceleration,uncertainty\n";
  for (int i = 0; i < 4 * 600; ++i)
    csv += fmt::format("{},{},0.25\n", 0.6 * i,
                       20 * std::cos(2 * std::numbers::pi * i / 600) + (i / 600 % 2 == 0 ? 0.5 : -0.5));
  write_file(folder.path() / "data.csv", csv);
  const auto study = [&](const std::string& target, const std::string& more = "") {
    write_file(folder.path() / "study.toml",
               head(guide()) + more + "[calibrate]\npoints = 5\nrevolutions = 2\n[calibrate.unknowns.c]\n" +
                   "key = \"joints.gudgeon.clearance\"\nlow = 0.2e-3\nhigh = 1e-3\n" +
                   "[calibrate.targets.t]\nstatistic = \"waveform\"\n" + target);
    return read_study(folder.path() / "study.toml");
  };
  const auto given = study("data = \"data.csv\"\ntolerance = 0.02\n");
  REQUIRE(given.measures.size() == 1);
  CHECK(given.measures[0].name == "waveform_t");
  const auto plan = plan_calibration(given, {});
  // The alternating part is an offset, which does not count: only t remains, in w and in its expectation.
  CHECK(plan.measured[0] == Approx(std::sqrt(2) * 0.02 * 20 / std::sqrt(2)).epsilon(1e-3));
  const auto run = run_case(given, Case{"", "nonsmooth", {}, 0, 2, given.scene, {}}, {});
  REQUIRE(run.measured.size() == 1);
  const auto mean = mean_of(run.metrics.turns);
  double squares = std::pow(0.02 * 20, 2) / 2;
  for (std::size_t k = 1; k < mean.size(); ++k) squares += 2 * std::norm(mean[k] - (k == 1 ? 10.0 : 0.0));
  CHECK(run.measured[0].value == Approx(std::sqrt(squares)).epsilon(1e-3));
  // A file of another crank speed says nothing about a run.
  const Case faster{"", "nonsmooth", {}, 0, 2, given.scene, {"drives.motor.speed_rpm=300"}};
  CHECK(std::isnan(run_case(given, faster, {}).measured[0].value));
  CHECK_THROWS_WITH(study("value = 3\n"), Contains("data") && Contains("is required for a waveform"));
  CHECK_THROWS_WITH(
      study("data = \"data.csv\"\n", "[measure.waveform_t]\ncolumn = \"t\"\nreduce = \"last\"\n"),
      Contains("measure waveform_t already has this name"));
}

TEST_CASE("a run compared with a noisy measurement contains its noise", "[calibrate][study]") {
  Study study;
  study.file = study.scene = guide();
  study.accelerometer = "accelerometer";
  study.joints = {"gudgeon"};
  study.discard = 1;
  Case one{"", "nonsmooth", {}, 0, 2, study.scene, {}};
  const auto rms = [&] { return run_case(study, one, {}).metrics.value[TurnMetrics::rms]; };
  const double quiet = rms();
  one.noise = 5;
  // 6,000 samples with a variance of 25: 25 ± 1.96·25√(2/6000) of the mean square, and as much of
  // the mixed term.
  const double noisy = rms();
  CHECK(noisy * noisy - quiet * quiet ==
        Approx(25).margin(1.96 * (25 * std::sqrt(2.0 / 6000) + 2 * 5 * quiet / std::sqrt(6000))));
  CHECK(rms() == noisy);
  one.start = 1;
  const auto other = identity(study, one, {}).digest();
  one.noise = 0;
  CHECK(identity(study, one, {}).digest() != other);
}

TEST_CASE("a fit that is rejected has no intervals; a measure of the study can be a target",
          "[calibrate][program]") {
  test::TemporaryFolder folder;
  const auto place = folder.path().string();
  const auto calibrated = [&](const std::string& target) {
    write_file(folder.path() / "study.toml", head(guide()) + R"([measure.first]
column = "t"
reduce = "first"
at = "main.angle crosses 30 deg upwards"
[measure.peak]
column = "accelerometer"
reduce = "peak"
[calibrate]
points = 6
starts = 2
revolutions = 1
refinements = 1
[calibrate.unknowns.c]
key = "joints.gudgeon.clearance"
low = 0.2e-3
high = 1e-3
)" + target);
    return test::freeplay("calibrate " + place + "/study.toml --allow-outside -o " + place + "/out");
  };
  const auto off =
      calibrated("[calibrate.targets.t]\nstatistic = \"rms\"\nvalue = 1000.0\ntolerance = 0.01\n");
  CAPTURE(off.out, off.err);
  CHECK(off.status == 1);
  CHECK_THAT(off.out, Contains("no interval: the fit is rejected"));
  std::ifstream in(folder.path() / "out/calibration.json");
  const auto json = nlohmann::json::parse(in);
  CHECK(json["fitted_to_all"]["unknowns"]["c"]["low"].is_null());
  CHECK(json["fitted_to_all"]["holds"] == false);
  CHECK(json["identifiability"]["unknowns"]["c"].contains("range_left_open"));
  const auto measure =
      calibrated("[calibrate.targets.t]\nstatistic = \"peak\"\nvalue = 40.0\ntolerance = 0.5\n");
  CAPTURE(measure.out, measure.err);
  CHECK(measure.status <= 1);
  CHECK_THAT(measure.out, Contains("Identifiability"));
  CHECK_THAT(calibrated("[calibrate.targets.t]\nstatistic = \"peak\"\ndata = \"x.csv\"\n").err,
             Contains("a measure of a run, which a file of a signal cannot provide"));
}

TEST_CASE("statistics that vary faster than the points of the design do not exclude the true value",
          "[calibrate][program]") {
  // A slider-crank whose statistics wave over the clearance with a period of a tenth of its range: 16 points do
  // not resolve that. The targets are those of runs with 0.25 mm, with 1 %, 0.2 % and 1 %. A surface that is
  // believed between its points rejected the true value.
  test::TemporaryFolder folder;
  const auto place = folder.path().string();
  write_file(folder.path() / "scene.toml",
             "gravity = [0, 0]\n" +
                 test::body("crank", 0.5, 5e-4,
                            "points = { shaft = [0, 0], pin = [0.05, 0], mass_centre = [0.01, 0] }\n") +
                 test::body("rod", 0.3, 1e-3,
                            "points = { crank = [0, 0], gudgeon = [0.2, 0], mass_centre = [0.08, 0] }\n") +
                 test::body("slider", 0.4, 2e-4) + R"([joints.shaft]
type = "revolute"
between = ["ground", "crank"]
at = [[0, 0], "shaft"]
[joints.crankpin]
type = "revolute"
between = ["crank", "rod"]
at = ["pin", "crank"]
[joints.gudgeon]
type = "revolute"
between = ["rod", "slider"]
at = ["gudgeon", [0, 0]]
clearance = 0.25e-3
bearing_radius = 0.01
surface = "steel"
)" + test::guide("guide", "ground", "slider") +
                 test::surface("steel", 0.5, "young = 207e9\npoisson = 0.3\nfriction = 0.12\n") +
                 test::drive("motor", "shaft", "speed_rpm = 200\n") + R"([run]
revolutions = 2
start = "ideal"
[instruments.acc]
type = "accelerometer"
body = "slider"
axis = [1, 0]
bandwidth = 2000
sampling = 10000
[nonsmooth]
scheme = "automatic"
)");
  const std::string head =
      "scene = \"scene.toml\"\njoint = \"gudgeon\"\naccelerometer = \"acc\"\n"
      "revolutions = 3\ndiscard = 1\nstarts = 2\n";
  write_file(folder.path() / "truth.toml", head);
  Study truth = read_study(folder.path() / "truth.toml");
  const auto made = run_case(truth, Case{"", "nonsmooth", {}, 0, 3, truth.scene, {}}, {}).metrics.value;
  auto text = head + R"([calibrate]
points = 16
starts = 2
revolutions = 3
leave_out = false
[calibrate.unknowns.clearance]
key = "joints.gudgeon.clearance"
low = 0.15e-3
high = 0.4e-3
scale = "log"
)";
  for (const auto& [name, value, tolerance] :
       {std::tuple("peak_median", made[TurnMetrics::peak_median], 0.01),
        std::tuple("rms", made[TurnMetrics::rms], 0.002),
        std::tuple("line_greatest", made[TurnMetrics::line_greatest], 0.01)})
    text += fmt::format("[calibrate.targets.{0}]\nstatistic = \"{0}\"\nvalue = {1}\ntolerance = {2}\n", name,
                        value, tolerance);
  write_file(folder.path() / "study.toml", text);
  const auto run = test::freeplay("calibrate " + place + "/study.toml --threads 1 -o " + place + "/out");
  CAPTURE(run.out, run.err);
  CHECK(run.status == 0);
  const auto fit = test::read_json(folder.path() / "out/calibration.json")["fitted_to_all"];
  REQUIRE(fit["settled"] == true);
  const auto& clearance = fit["unknowns"]["clearance"];
  CHECK(clearance["low"].get<double>() < 0.25e-3);
  CHECK(clearance["high"].get<double>() > 0.25e-3);
  // A fifth of the range: the runs do resolve the wave.
  CHECK(clearance["high"].get<double>() - clearance["low"].get<double>() < 0.05e-3);
}
