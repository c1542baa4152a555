#include "measure/turns.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <complex>
#include <numbers>
#include <unsupported/Eigen/FFT>

namespace freeplay {
namespace {

constexpr double pi = std::numbers::pi;
const double nan = std::nan("");

double mean(const std::vector<double>& x) {
  double sum = 0;
  for (double v : x) sum += v;
  return x.empty() ? nan : sum / static_cast<double>(x.size());
}

}  // namespace

const std::array<std::string_view, TurnMetrics::count>& TurnMetrics::names() {
  static constexpr std::array<std::string_view, count> names = {
      "peak_5",       "peak_median", "peak_95",       "peak_max",         "ratio_median",
      "ratio_95",     "ratio_max",   "rms",           "impacts_per_turn", "flights_per_turn",
      "flight_share", "loss_angle",  "return_angle",  "flight_duration",  "deceleration",
      "lines",        "lines_total", "line_greatest", "energy_per_turn"};
  return names;
}

double quantile(const std::vector<double>& sorted, double p) {
  if (sorted.empty()) return nan;
  const double at = p * static_cast<double>(sorted.size() - 1);
  const auto i = static_cast<std::size_t>(at);
  if (i + 1 >= sorted.size()) return sorted.back();
  return sorted[i] + (at - static_cast<double>(i)) * (sorted[i + 1] - sorted[i]);
}

double mean_angle(const std::vector<double>& degrees) {
  if (degrees.empty()) return nan;
  std::complex<double> sum = 0;
  for (double d : degrees) sum += std::polar(1.0, d * pi / 180);
  const double angle = std::arg(sum) * 180 / pi;
  return angle < 0 ? angle + 360 : angle;
}

std::vector<double> harmonics(const std::vector<double>& signal, double points, int turns, int highest) {
  const auto n = std::bit_ceil(static_cast<std::size_t>(std::ceil(2 * points)));
  std::vector<double> power(static_cast<std::size_t>(highest)), turn(n);
  std::vector<std::complex<double>> transform;
  Eigen::FFT<double> fft;
  for (int k = 0; k < turns; ++k) {
    for (std::size_t i = 0; i < n; ++i) {
      const double at = (k + static_cast<double>(i) / static_cast<double>(n)) * points;
      const auto j = std::min(static_cast<std::size_t>(at), signal.size() - 2);
      turn[i] = signal[j] + (at - static_cast<double>(j)) * (signal[j + 1] - signal[j]);
    }
    fft.fwd(transform, turn);
    for (std::size_t h = 0; h < power.size() && h + 1 < n / 2; ++h)
      power[h] += std::norm(2.0 / static_cast<double>(n) * transform[h + 1]);
  }
  for (auto& p : power) p = std::sqrt(p / std::max(turns, 1));
  return power;
}

double TurnMeter::degrees(double t) const {
  const double d = std::fmod((rules_.crank_start + rules_.speed * t) * 180 / pi, 360);
  return d < 0 ? d + 360 : d;
}

void TurnMeter::event(const ContactEvent& e) {
  if (e.contact != rules_.joint) return;
  if (e.kind == EventKind::separation) {
    left_at_ = e.t;
    return;
  }
  if (left_at_ >= rules_.discard) flights_.emplace_back(left_at_, e.t);
  left_at_ = e.kind == EventKind::impact ? e.t + e.duration : -1;
  if (e.t >= rules_.discard && -e.v_n_minus >= rules_.impact_speed)
    impacts_.push_back({degrees(e.t), -e.v_n_minus, e.impulse_n});
}

void TurnMeter::acceleration(double t, double value) {
  if (t < rules_.discard) return;
  if (first_a_ < 0) first_a_ = std::lround(t * rules_.sampling);
  acceleration_.push_back(value);
}

void TurnMeter::position(double t, double value) {
  if (t < rules_.discard) return;
  if (first_x_ < 0) first_x_ = std::lround(t * rules_.sampling);
  position_.push_back(value);
}

void TurnMeter::flight(TurnMetrics& m, double from, double to) const {
  Flight f{degrees(from), std::abs(rules_.speed) * (to - from) * 180 / pi, to - from, nan};
  if (f.angle < rules_.flight_angle) return;
  const long i = static_cast<long>(std::ceil(from * rules_.sampling)) - first_x_;
  const long j = static_cast<long>(std::floor(to * rules_.sampling)) - first_x_;
  const long half = (j - i) / 2;
  if (i >= 0 && half >= 4 && i + 2 * half < static_cast<long>(position_.size())) {
    const double a = position_[i], b = position_[i + half], c = position_[i + 2 * half];
    const double T = static_cast<double>(half) / rules_.sampling;
    f.deceleration = -std::copysign((a - 2 * b + c) / (T * T), (a - 2 * b + c) * (c - a));
  }
  m.flights.push_back(f);
}

TurnMetrics TurnMeter::finish(double energy_lost) const {
  TurnMetrics m;
  const double points = 2 * pi / std::abs(rules_.speed) * rules_.sampling;
  const int turns = static_cast<int>((static_cast<double>(acceleration_.size()) + 0.5) / points);
  auto& v = m.value;
  v.fill(nan);
  if (turns < 1) return m;
  double squares = 0;
  for (int k = 0; k < turns; ++k) {
    double peak = 0;
    for (auto i = static_cast<std::size_t>(k * points); i < static_cast<std::size_t>((k + 1) * points); ++i) {
      peak = std::max(peak, std::abs(acceleration_[i]));
      squares += acceleration_[i] * acceleration_[i];
    }
    m.peaks.push_back(peak);
  }
  auto sorted = m.peaks;
  std::ranges::sort(sorted);
  v[TurnMetrics::peak_5] = quantile(sorted, 0.05);
  v[TurnMetrics::peak_median] = quantile(sorted, 0.5);
  v[TurnMetrics::peak_95] = quantile(sorted, 0.95);
  v[TurnMetrics::peak_max] = sorted.back();
  v[TurnMetrics::ratio_median] = v[TurnMetrics::peak_median] / rules_.ideal_maximum;
  v[TurnMetrics::ratio_95] = v[TurnMetrics::peak_95] / rules_.ideal_maximum;
  v[TurnMetrics::ratio_max] = v[TurnMetrics::peak_max] / rules_.ideal_maximum;
  v[TurnMetrics::rms] = std::sqrt(squares / (turns * points));

  for (const auto& [from, to] : flights_) flight(m, from, to);
  m.impacts = impacts_;
  std::vector<double> losses, returns, durations, decelerations;
  double flying = 0;
  // The longest flight of each turn stands for its loss of contact.
  for (const auto& [from, to] : flights_) flying += to - from;
  for (const auto& f : m.flights) {
    durations.push_back(f.duration);
    if (std::isfinite(f.deceleration)) decelerations.push_back(f.deceleration);
    losses.push_back(f.loss);
    returns.push_back(std::fmod(f.loss + f.angle, 360));
  }
  v[TurnMetrics::impacts_per_turn] = static_cast<double>(impacts_.size()) / turns;
  v[TurnMetrics::flights_per_turn] = static_cast<double>(m.flights.size()) / turns;
  v[TurnMetrics::flight_share] = flying / (turns * points / rules_.sampling);
  v[TurnMetrics::loss_angle] = mean_angle(losses);
  v[TurnMetrics::return_angle] = mean_angle(returns);
  v[TurnMetrics::flight_duration] = mean(durations);
  v[TurnMetrics::deceleration] = mean(decelerations);

  m.spectrum = harmonics(acceleration_, points, turns, static_cast<int>(points / 2.5));
  v[TurnMetrics::lines] = v[TurnMetrics::lines_total] = v[TurnMetrics::line_greatest] = 0;
  for (std::size_t h = 0; h < m.spectrum.size(); ++h) {
    if (m.spectrum[h] >= rules_.line_share * rules_.ideal_maximum) {
      ++v[TurnMetrics::lines];
      v[TurnMetrics::lines_total] += m.spectrum[h];
    }
    // The ideal motion's own lines are the first two.
    if (h >= 2) v[TurnMetrics::line_greatest] = std::max(v[TurnMetrics::line_greatest], m.spectrum[h]);
  }
  v[TurnMetrics::energy_per_turn] = energy_lost / turns;

  m.mean_turn.assign(mean_bins, 0);
  std::vector<int> fill(mean_bins, 0);
  for (std::size_t i = 0; i < static_cast<std::size_t>(turns * points); ++i) {
    const double at = degrees(static_cast<double>(first_a_ + static_cast<long>(i)) / rules_.sampling);
    const auto bin = std::min<std::size_t>(static_cast<std::size_t>(at / 360 * mean_bins), mean_bins - 1);
    m.mean_turn[bin] += acceleration_[i];
    ++fill[bin];
  }
  for (int b = 0; b < mean_bins; ++b)  // coarse sampling leaves bins empty: they take their neighbour's mean
    m.mean_turn[b] = fill[b] > 0 ? m.mean_turn[b] / fill[b] : m.mean_turn[(b + mean_bins - 1) % mean_bins];

  // The last whole turn that begins at crank angle 0; without one (a single turn), the last samples.
  const auto count = static_cast<std::size_t>(points);
  const auto time = [&](std::size_t i) {
    return static_cast<double>(first_a_ + static_cast<long>(i)) / rules_.sampling;
  };
  const auto turn = [&](std::size_t i) {
    return std::floor((rules_.crank_start + rules_.speed * time(i)) / (2 * pi));
  };
  std::size_t first = acceleration_.size() - count;
  for (std::size_t i = first; i > 0; --i)
    if (turn(i) != turn(i - 1)) {
      first = i;
      break;
    }
  for (std::size_t i = first; i < first + count; ++i)
    m.last_turn.push_back({degrees(time(i)), acceleration_[i], i < position_.size() ? position_[i] : nan});
  std::ranges::sort(m.last_turn, {}, &TracePoint::angle);
  return m;
}

}  // namespace freeplay
