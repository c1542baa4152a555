// Test of equal means: closed forms in one dimension, and its probability of error on random samples.
#include "measure/waveform.hpp"

#include <catch2/catch.hpp>

#include <cmath>
#include <random>

using namespace freeplay;

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
