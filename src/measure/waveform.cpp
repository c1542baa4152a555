#include "measure/waveform.hpp"

#include <algorithm>
#include <numbers>

#include "measure/alignment.hpp"
#include "numerics/quantiles.hpp"

namespace freeplay {
namespace {

constexpr std::size_t most_members = 64;  // longer samples are averaged over consecutive members

double inner(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += a[i] * b[i];
  return sum;
}

std::vector<double> average(const Samples& x, std::size_t from, std::size_t to) {
  std::vector<double> mean(x[from].size());
  for (auto k = from; k < to; ++k)
    for (std::size_t i = 0; i < mean.size(); ++i) mean[i] += x[k][i] / static_cast<double>(to - from);
  return mean;
}

/// V = c Σ r rᵀ of the mean of a sample.
struct SampleSpread {
  Samples r;
  double c = 0;
  double freedom = 0;  // ν

  explicit SampleSpread(const Samples& x) {
    const auto n = std::min(x.size(), most_members);
    for (std::size_t k = 0; k < n; ++k) r.push_back(average(x, k * x.size() / n, (k + 1) * x.size() / n));
    const auto mean = average(r, 0, n);
    for (auto& one : r)
      for (std::size_t i = 0; i < mean.size(); ++i) one[i] -= mean[i];
    const double members = static_cast<double>(n), time = correlation_time();
    freedom = std::max(1.0, members / time - 1);
    if (n > 1) c = time / (members * (members - 1));
  }
  double squares(std::size_t lag) const {
    double sum = 0;
    for (auto k = lag; k < r.size(); ++k) sum += inner(r[k], r[k - lag]);
    return sum;
  }
  double correlation_time() const {
    const double whole = squares(0);
    double time = -1;
    for (std::size_t lag = 0; whole > 0 && lag + 1 < r.size(); lag += 2) {
      const double pair = (squares(lag) + squares(lag + 1)) / whole;
      if (!(pair > 0)) break;
      time += 2 * pair;
    }
    return std::clamp(time, 1.0, std::max(1.0, static_cast<double>(r.size()) / 2));
  }
  double trace() const { return c * squares(0); }
  /// tr(V V′).
  double product(const SampleSpread& other) const {
    double sum = 0;
    for (const auto& a : r)
      for (const auto& b : other.r) sum += inner(a, b) * inner(a, b);
    return c * other.c * sum;
  }
  /// The variance of a single member of the other sample.
  void take(const SampleSpread& other) {
    r = other.r;
    c = 1 / (static_cast<double>(r.size()) - 1);
    freedom = other.freedom;
  }
};

}  // namespace

MeanDifference difference_of_means(const Samples& x, const Samples& y, double common, double error) {
  MeanDifference d;
  const auto a = average(x, 0, x.size()), b = average(y, 0, y.size());
  for (std::size_t i = 0; i < a.size(); ++i) d.size += (a[i] - b[i]) * (a[i] - b[i]);
  d.size = std::sqrt(d.size);
  SampleSpread v(x), w(y);
  if (x.size() < 2 && y.size() < 2 && !(common > 0)) return d;
  const bool shared = x.size() < 2 || y.size() < 2;  // one estimate is both variances
  if (x.size() < 2 && y.size() > 1) v.take(w);
  if (y.size() < 2 && x.size() > 1) w.take(v);
  const double u = common * common, all = v.trace() + w.trace() + u;
  d.expected = std::sqrt(all);
  const double vv = v.product(v), ww = w.product(w), estimated = vv + 2 * v.product(w) + ww,
               both = estimated + u * u;
  constexpr double many = 1e6;
  const double unknown = shared ? estimated / v.freedom : vv / v.freedom + ww / w.freedom;
  const double f0 = unknown > 0 ? std::min(many, all * all / unknown) : many;
  d.limit = both > 0 ? std::sqrt(all * fisher_upper_quantile(std::max(1.0, all * all / both), f0, error)) : 0;
  return d;
}

namespace {

std::size_t least_count(const std::vector<Harmonics>& turns) {
  return std::ranges::min_element(turns, {}, &Harmonics::size)->size();
}

/// ‖x‖² of the harmonics 1 … count − 1.
double power(const Harmonics& x, std::size_t count) {
  double sum = 0;
  for (std::size_t k = 1; k < count; ++k) sum += 2 * std::norm(x[k]);
  return sum;
}

}  // namespace

MeasuredTurns turns_of(const Measurement& measured, double speed) {
  TurnRules rules;
  rules.speed = speed;
  rules.crank_start = measured.start_angle * std::numbers::pi / 180;
  rules.joint = -1;
  TurnMeter meter(rules);
  for (std::size_t i = 0; i < measured.acceleration.size(); ++i)
    meter.acceleration(measured.time[i], measured.acceleration[i]);
  return {meter.finish(measured.time.back(), NAN).turns, measured.datum};
}

double waveform_difference(const MeasuredTurns& measured, const std::vector<Harmonics>& model,
                           double tolerance) {
  if (measured.turns.empty() || model.empty()) return NAN;
  const auto count = std::min(least_count(measured.turns), least_count(model));
  const auto y = mean_of(measured.turns);
  auto x = mean_of(model);
  if (!measured.datum) {
    const auto found = align(measured.turns, model);
    x = moved(std::move(x), found.phase);
    for (auto& c : x) c *= found.sign;  // a reversed sensor
  }
  const double size = power(y, count);
  for (std::size_t k = 1; k < count; ++k) x[k] -= y[k];
  return std::sqrt(power(x, count) + tolerance * tolerance * size);
}

ExpectedDifference expected_difference(const MeasuredTurns& measured, int turns, double tolerance) {
  if (measured.turns.size() < 2) return {NAN, NAN};
  const auto count = least_count(measured.turns);
  Samples all;
  for (const auto& turn : measured.turns) {
    auto& list = all.emplace_back();
    for (std::size_t k = 1; k < count; ++k) {
      list.push_back(std::numbers::sqrt2 * turn[k].real());
      list.push_back(std::numbers::sqrt2 * turn[k].imag());
    }
  }
  const double u = tolerance * std::sqrt(power(mean_of(measured.turns), count));
  // Two means of as many turns as were measured differ by 2 tr V_y. A run has fewer turns and the
  // same correlation, which its own turns would determine less well.
  const double more = 0.5 * (1 + static_cast<double>(all.size()) / std::max(turns, 1));
  constexpr double error = 0.05, quantile = 1.645;  // of the normal distribution
  const auto d = difference_of_means(all, all, u / std::sqrt(more), error);
  const double expected = std::hypot(std::sqrt(more) * d.expected, u);
  return {expected, std::log(std::hypot(std::sqrt(more) * d.limit, u) / expected) / quantile};
}

}  // namespace freeplay
