// The difference of mean turns as a target of calibration, on synthetic turns of known statistics; and
// the test of equal means: closed forms in one dimension, and its probability of error on random samples.
#include "measure/waveform.hpp"

#include <catch2/catch.hpp>

#include <cmath>
#include <random>

#include "measure/alignment.hpp"

using namespace freeplay;

namespace {

/// Turns with the harmonics c plus deviations that follow each other with the correlation r^lag.
std::vector<Harmonics> turns(std::mt19937_64& engine, const Harmonics& c, int count, double scatter,
                             double r) {
  std::normal_distribution<double> normal;
  std::vector<Harmonics> list;
  Harmonics off(c.size());
  for (auto& x : off) x = scatter * std::complex(normal(engine), normal(engine));
  for (int i = 0; i < count; ++i) {
    auto& turn = list.emplace_back(c);
    for (std::size_t k = 0; k < c.size(); ++k) {
      turn[k] += off[k];
      off[k] = r * off[k] + std::sqrt(1 - r * r) * scatter * std::complex(normal(engine), normal(engine));
    }
  }
  return list;
}

const Harmonics shape{0.4, {1, 2}, {0.5, -1}, {0, 0.3}, {-0.2, 0.1}, {0.05, 0}};

}  // namespace

TEST_CASE("the difference of mean turns is a root mean square over the turn", "[waveform]") {
  Harmonics other = shape;
  other[0] += 7;  // an offset does not count
  other[2] += std::complex(0.3, -0.4);
  CHECK(waveform_difference({{shape}, true}, {other}, 0) == Approx(std::sqrt(2) * 0.5).epsilon(1e-12));
  double size = 0;
  for (std::size_t k = 1; k < shape.size(); ++k) size += 2 * std::norm(shape[k]);
  CHECK(waveform_difference({{shape}, true}, {shape}, 0.02) == Approx(0.02 * std::sqrt(size)).epsilon(1e-12));
  CHECK(std::isnan(waveform_difference({{}, true}, {shape}, 0.02)));
}

TEST_CASE("without crank angles, mean turns are aligned before they are compared", "[waveform]") {
  std::mt19937_64 engine(3);
  const auto measured = turns(engine, shape, 12, 1e-3, 0);
  const std::vector<Harmonics> model{moved(shape, 0.7), moved(shape, 0.7)};
  CHECK(waveform_difference({measured, true}, model, 0) > 0.5);
  CHECK(waveform_difference({measured, false}, model, 0) < 2e-3);
  auto reversed = measured;
  for (auto& turn : reversed)
    for (auto& c : turn) c = -c;
  CHECK(waveform_difference({reversed, false}, model, 0) < 2e-3);
}

TEST_CASE("the expected difference is that of runs of the measured motion, also with correlated turns",
          "[waveform]") {
  // Against 400 pairs of independent samples: the mean square within 20 %, because correlation
  // times of independent turns are estimated as at least 1 and thus on average too long; the spread
  // of the logarithms within a third.
  for (const double r : {0.0, 0.5}) {
    std::mt19937_64 engine(17);
    double squares = 0, expected = 0, logs = 0, logs2 = 0, deviation = 0;
    const int pairs = 400;
    for (int i = 0; i < pairs; ++i) {
      const MeasuredTurns measured{turns(engine, shape, 80, 0.1, r), true};
      const double w = waveform_difference(measured, turns(engine, shape, 20, 0.1, r), 0);
      const auto e = expected_difference(measured, 20, 0);
      squares += w * w / pairs;
      expected += e.value * e.value / pairs;
      logs += std::log(w) / pairs;
      logs2 += std::log(w) * std::log(w) / pairs;
      deviation += e.deviation / pairs;
    }
    CAPTURE(r, squares, expected, logs, logs2, deviation);
    CHECK(expected == Approx(squares).epsilon(0.2));
    CHECK(deviation == Approx(std::sqrt(logs2 - logs * logs)).epsilon(0.34));
  }
  CHECK(std::isnan(expected_difference({{shape}, true}, 20, 0).value));
}

TEST_CASE("in one dimension the test of equal means is Welch's", "[measure]") {
  // Means 1 and 6, variances of the means 1 and 1, two degrees of freedom: t(0.975) = 4.30265.
  const auto d = difference_of_means({{0}, {2}}, {{5}, {7}}, 0, 0.05);
  CHECK(d.size == 5);
  CHECK(d.expected == Approx(std::sqrt(2)).epsilon(1e-14));
  CHECK(d.limit == Approx(std::sqrt(2) * 4.30265).epsilon(1e-5));
  // Variances of the means 1 and 1/3: (4/3)²/(1 + 1/9) = 1.6 degrees of freedom, t = 5.4827.
  const auto w = difference_of_means({{0}, {2}}, {{5}, {7}, {5}, {7}}, 0, 0.05);
  CHECK(w.expected == Approx(std::sqrt(4.0 / 3)).epsilon(1e-14));
}

TEST_CASE("a common error is a normal deviate in one direction", "[measure]") {
  const auto d = difference_of_means({{1, 0}}, {{0, 0}}, 2, 0.05);
  CHECK(d.size == 1);
  CHECK(d.limit == Approx(2 * 1.959964).epsilon(1e-5));
  // Nothing is known of single members without it.
  CHECK(std::isnan(difference_of_means({{1, 0}}, {{0, 0}}, 0, 0.05).limit));
  // A single member has the variance of the other sample, 2: V = 2 + 1 = 3, one degree of freedom.
  const auto one = difference_of_means({{1}}, {{5}, {7}}, 0, 0.05);
  CHECK(one.expected == Approx(std::sqrt(3)).epsilon(1e-14));
  CHECK(one.limit == Approx(std::sqrt(3) * 12.7062).epsilon(1e-5));
}

TEST_CASE("equal means are found to differ as often as stated", "[measure]") {
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  // Vectors whose components have variances 1, 1/4, 1/9, …; correlated in time by `memory`.
  const auto sample = [&](int members, int size, double scale, double memory) {
    Samples x;
    std::vector<double> state(size);
    for (auto& s : state) s = normal(random);
    for (int k = 0; k < members; ++k) {
      auto& one = x.emplace_back(size);
      for (int i = 0; i < size; ++i) {
        state[i] = memory * state[i] + std::sqrt(1 - memory * memory) * normal(random);
        one[i] = scale * state[i] / (1 + i);
      }
    }
    return x;
  };
  struct Case {
    int size, a, b;
    double scale, memory, least, most;
  };
  // 1,000 trials scatter by 0.7 %. Correlation times not below 1 make the test conservative; Box's
  // approximation may exceed the 5 % by a half, and estimated correlation times by their whole.
  for (const auto& c : {Case{1, 12, 20, 3, 0, 0.01, 0.08}, Case{6, 12, 20, 3, 0, 0.01, 0.08},
                        Case{40, 8, 40, 1, 0, 0.01, 0.08}, Case{6, 60, 40, 2, 0.5, 0.01, 0.12}}) {
    CAPTURE(c.size, c.a, c.memory);
    constexpr int trials = 1000;
    int found = 0;
    for (int i = 0; i < trials; ++i) {
      const auto d = difference_of_means(sample(c.a, c.size, c.scale, c.memory),
                                         sample(c.b, c.size, 1, c.memory), 0, 0.05);
      found += d.size > d.limit;
    }
    CHECK(found > c.least * trials);
    CHECK(found < c.most * trials);
  }
}
