// Statistics of the measuring chain, on synthetic values with known results: means of directions,
// intervals, predictions, the intervals of a calibration, counts, and the ideal mechanism's maximum.
#include <boost/math/distributions/students_t.hpp>
#include <complex>

#include "simulation/statistics.hpp"
#include "study/calibration/calibrate.hpp"
#include "study/runs/turns.hpp"
#include "study/store/results.hpp"
#include "verification/references/slider_crank.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;

TEST_CASE("directions are averaged on the circle", "[chain]") {
  const auto s = interval_of_directions({350, 10, 30, 10});
  CHECK(s.mean == Approx(10));
  const double half = boost::math::quantile(boost::math::students_t(3), 0.975) * std::sqrt(800.0 / 3 / 4);
  CHECK(s.low == Approx(10 - half));
  CHECK(s.high == Approx(10 + half));
  CHECK(s.least == Approx(-10));
  CHECK(s.greatest == Approx(30));
  CHECK(std::isnan(interval_of_directions({0, 120, 230}).low));  // anywhere
  std::vector<RunRow> rows(2);
  for (auto& r : rows) r.variant = "v", r.formulation = "penalty";
  rows[0].metric[TurnMetrics::loss_angle] = 355;
  rows[1].metric[TurnMetrics::loss_angle] = 15;
  CHECK(cell(rows, "v", "penalty", {}, TurnMetrics::loss_angle).mean == Approx(5));
}

TEST_CASE("a confidence interval stays within the range of its quantity", "[chain]") {
  const auto s = interval({1, 2, 600, 3});
  REQUIRE(s.low < 0);
  const auto positive = within_range(s, TurnMetrics::Kind::positive);
  CHECK(positive.low == Approx(s.mean * std::exp((s.low - s.mean) / s.mean)));
  CHECK(positive.low > 0);
  CHECK(positive.mean == s.mean);
  const auto share = within_range(interval({0.9, 0.99, 0.6, 0.98}), TurnMetrics::Kind::share);
  CHECK(share.high < 1);
  CHECK(share.low > 0);
  // A narrow interval is that of Student's t, to second order in its width.
  const auto narrow = interval({0.5, 0.5001, 0.4999});
  for (const auto kind : {TurnMetrics::Kind::positive, TurnMetrics::Kind::share})
    CHECK(within_range(narrow, kind).low == Approx(narrow.low).epsilon(1e-6));
  // If some outcomes are zero, zero is within the interval.
  const auto e = one_more({0, 0, 3, 4, 5});
  CHECK(e.low == 0);
  CHECK(e.value == 3);
  CHECK(e.high > 5);
}

TEST_CASE("runs contradict a fit beyond 99 % prediction limits that include the tolerance of the target",
          "[chain]") {
  // ln r of ±0.1 about 0: s = 0.1√(8/7), one more of 8: t₇(0.995) s √(9/8) = 3.4995·0.1069·1.0607.
  std::vector<double> runs;
  for (int i = 0; i < 8; ++i) runs.push_back(std::exp(i % 2 ? 0.1 : -0.1));
  const double one = 3.499483 * 0.1 * std::sqrt(8.0 / 7) * std::sqrt(9.0 / 8);
  const double edge = std::hypot(one, 2.575829 * 0.1);
  CHECK_FALSE(contradicts(runs, std::exp(edge * 0.999), 0.1, 0));
  CHECK(contradicts(runs, std::exp(edge * 1.001), 0.1, 0));
  CHECK(contradicts({1, 0}, 1, 0.1, 0.1));
  CHECK(contradicts({1}, std::exp(2.575829 * 0.3 * 1.001), 0, 0.3));
  // The optimum is one of the points within the surface's own error: 2.58 of that in addition.
  const double wide = std::hypot(edge, 2.575829 * 0.2);
  CHECK_FALSE(contradicts(runs, std::exp(wide * 0.999), 0.1, 0.2));
  CHECK(contradicts(runs, std::exp(wide * 1.001), 0.1, 0.2));
  // The mean of four segments that scatter like runs: t s √(1/4 + 1/8).
  const double variance = 0.01 * 8 / 7, mean = 3.499483 * std::sqrt(variance) * std::sqrt(1.0 / 4 + 1.0 / 8);
  CHECK_FALSE(contradicts(runs, std::exp(mean * 0.999), 0, 0, {4, variance}));
  CHECK(contradicts(runs, std::exp(mean * 1.001), 0, 0, {4, variance}));
  // Segments that all agree count as one outcome, whatever their number.
  CHECK_FALSE(contradicts(runs, std::exp(mean * 1.001), 0, 0, {4, 0}));
}

TEST_CASE("the mean of a measurement in one persistent state has the uncertainty of the state", "[chain]") {
  // x = b + e with a state b common to all of five segments, and e in each: Var x = B + E, of the
  // mean B + E/5.
  std::mt19937_64 engine(5);
  std::normal_distribution<double> normal;
  constexpr double B = 0.03, E = 0.01;
  constexpr int count = 5, repetitions = 40000;
  double squares = 0, shares = 0;
  for (int k = 0; k < repetitions; ++k) {
    const double b = std::sqrt(B) * normal(engine);
    double sum = 0, square = 0;
    for (int i = 0; i < count; ++i) {
      const double x = b + std::sqrt(E) * normal(engine);
      sum += x, square += x * x;
    }
    const double spread = (square - sum * sum / count) / (count - 1);
    squares += sum * sum / count / count / repetitions;
    shares += Stretches{count, spread}.share(B + E) / repetitions;
  }
  // From 40,000 repetitions a variance is known to √(2/40000) = 0.7 %; the bound is three of these.
  // A spread above B + E counts as B + E: one of 300, with four degrees of freedom.
  CHECK(shares * (B + E) == Approx(squares).epsilon(0.021));
  CHECK(Stretches{count, 0.04}.share(0.04) == Approx(1.0 / count));
  CHECK(Stretches{}.share(0.04) == 1);
}

TEST_CASE("confidence intervals of a calibration cover the truth in forty repetitions", "[chain]") {
  // Outcomes are a quadratic with noise of 0.1; the measurement is one more outcome, read with a
  // tolerance of 0.05. Of 80 intervals of 95 % more than 68 contain the truth with a probability of
  // 99.9 % (binomial).
  const std::vector<Unknown> unknowns{{"a", "a", "", -1, 1}, {"b", "b", "", -1, 1}};
  const auto y = [](int i, const Eigen::VectorXd& x) {
    switch (i) {
      case 0:
        return 1 + 1.5 * x[0] + 0.5 * x[1] + 0.2 * x[0] * x[1];
      case 1:
        return 0.3 - 0.8 * x[0] + 1.2 * x[1] + 0.15 * x[1] * x[1];
      default:
        return -1 + 0.4 * x[0] - 1.6 * x[1];
    }
  };
  std::mt19937_64 engine(18);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform(-0.7, 0.7);
  const auto points = space_filling(2, 24);
  int held = 0;
  double widest = 0;
  for (int repetition = 0; repetition < 40; ++repetition) {
    const Eigen::Vector2d truth(uniform(engine), uniform(engine));
    std::vector<Observed> targets;
    for (int i = 0; i < 3; ++i) {
      Eigen::VectorXd outcomes(24);
      for (int p = 0; p < 24; ++p) outcomes[p] = y(i, points.row(p).transpose()) + 0.1 * normal(engine);
      targets.push_back({ResponseSurface(points, outcomes),
                         y(i, truth) + std::hypot(0.1, 0.05) * normal(engine),
                         0.05,
                         {},
                         i,
                         0,
                         i});
    }
    const auto f = fit(Misfit(targets, std::vector<Scatter>(3)), {true, true, true}, unknowns);
    for (int j = 0; j < 2; ++j) {
      held += f.unknowns[j].low <= truth[j] && truth[j] <= f.unknowns[j].high;
      widest = std::max(widest, f.unknowns[j].high - f.unknowns[j].low);
    }
  }
  CAPTURE(held, widest);
  CHECK(held > 68);
  CHECK(widest < 0.8);  // and are informative: of a range of 2
}

TEST_CASE("impacts are counted by their value", "[chain]") {
  FastOnes fast;
  for (double v : {0.05, 0.2, 0.0999, 0.1, 1.0, 0.09999, 0.1, 0.100001, 0.5}) fast.add(v);
  CHECK(fast.at_least(0.1 * fast.greatest()) == 6);  // 0.2, 0.1, 1, 0.1, 0.100001, 0.5
  // For any number: 1,000 of each of 0.099 and 0.101 before and after one of 1.
  FastOnes many;
  for (int i = 0; i < 1000; ++i) many.add(0.099), many.add(0.101);
  many.add(1);
  for (int i = 0; i < 1000; ++i) many.add(0.099), many.add(0.101);
  CHECK(many.at_least(0.1) == 2001);
  // Merged windows have the greatest of both, thinned or not: 700 from 0.2 to 1.
  FastOnes thinned, joined;
  for (int i = 0; i < 700; ++i) thinned.add(0.2 + 0.8 * i / 699);
  joined.add(0.15);
  joined.add(thinned);
  CHECK(joined.greatest() == 1);
  CHECK(joined.at_least(0.1 * joined.greatest()) == 701);
}

TEST_CASE("the greatest acceleration of the ideal mechanism is that of a settled filter", "[chain]") {
  // Through 1 Hz at 3.33 revolutions a second the initial transient has decayed to
  // e^(−2π·1·0.707·0.3) = 0.26 after one revolution. In the settled state, harmonic k of the closed
  // form is multiplied by H(ikω) = 1/(1 + √2 s/ω_c + (s/ω_c)²).
  const auto file = test::source_folder() / "cases/flores2011-experiment/guide.toml";
  const auto scene = read_scene(file, {"instruments.accelerometer.bandwidth=1"});
  Study study;
  study.file = study.scene = file;
  study.accelerometer = "accelerometer";
  study.joints = {"gudgeon"};
  const auto ideal = ideal_metrics(study, scene, "penalty", {});
  constexpr double pi = std::numbers::pi, omega = 200 * 2 * pi / 60;
  constexpr int points = 3000;  // as many samples as the revolution has, at 10 kHz
  std::vector<std::complex<double>> lines(20), filtered(points);
  for (std::size_t k = 1; k < lines.size(); ++k) {
    for (int i = 0; i < points; ++i)
      lines[k] += reference::slider_crank(0.05, 0.3, 2 * pi * i / points, omega).acceleration *
                  std::polar(2.0 / points, -2 * pi * static_cast<double>(k) * i / points);
    const std::complex<double> s(0, static_cast<double>(k) * omega / (2 * pi));
    lines[k] /= 1.0 + std::sqrt(2.0) * s + s * s;
  }
  double greatest = 0;
  for (int i = 0; i < points; ++i) {
    double y = 0;
    for (std::size_t k = 1; k < lines.size(); ++k)
      y += std::real(lines[k] * std::polar(1.0, 2 * pi * static_cast<double>(k) * i / points));
    greatest = std::max(greatest, std::abs(y));
  }
  CHECK(ideal.value[TurnMetrics::peak_max] == Approx(greatest).epsilon(1e-4));
}
