#include "measure/waveform.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "measure/alignment.hpp"
#include "measure/mean_difference.hpp"

namespace freeplay {
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
