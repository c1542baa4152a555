#include "measure/turns.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <optional>

#include "measure/alignment.hpp"

namespace freeplay {
namespace {

const double nan = std::nan("");

double mean(const std::vector<double>& x) {
  double sum = 0;
  for (double v : x) sum += v;
  return x.empty() ? nan : sum / static_cast<double>(x.size());
}

}  // namespace

const std::array<std::string_view, TurnMetrics::count>& TurnMetrics::names() {
  static constexpr std::array<std::string_view, count> names = {
      "peak_5",         "peak_median", "peak_95",       "peak_max",         "ratio_median",
      "ratio_95",       "ratio_max",   "rms",           "impacts_per_turn", "flights_per_turn",
      "flight_share",   "loss_angle",  "return_angle",  "flight_duration",  "deceleration",
      "lines",          "lines_total", "line_greatest", "mean_turn_rms",    "mean_turn_peak",
      "energy_per_turn"};
  return names;
}

TurnMetrics::Kind TurnMetrics::kind(Name name) {
  switch (name) {
    case flight_share:
      return Kind::share;
    case loss_angle:
    case return_angle:
      return Kind::direction;
    case deceleration:
      return Kind::real;
    default:
      return Kind::positive;
  }
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
  for (double d : degrees) sum += std::polar(1.0, d * std::numbers::pi / 180);
  return whole_circle(std::arg(sum) * 180 / std::numbers::pi);
}

double whole_circle(double degrees) {
  const double d = std::fmod(degrees, 360);
  return d < 0 ? d + 360 : d;
}

double half_circle(double degrees) { return whole_circle(degrees + 180) - 180; }

double TurnMeter::degrees(double t) const {
  if (rules_.speed == 0) return nan;
  return whole_circle((rules_.crank_start + rules_.speed * t) * 180 / std::numbers::pi);
}

double TurnMeter::turn() const { return 2 * std::numbers::pi / std::abs(rules_.speed); }

/// The contact is closed from t to `until`; NaN: until its next separation.
void TurnMeter::touch(Touching& one, int contact, double t, double until) {
  if (!std::isnan(one.left_at)) {
    flown_ += std::max(0.0, t - std::max(one.left_at, rules_.discard));
    if (one.lost && t >= rules_.discard) flights_.push_back({one.left_at, t, contact});
  }
  one.left_at = until;
  one.lost = !std::isnan(until);
}

void TurnMeter::event(const ContactEvent& e) {
  std::size_t own = 0;
  if (e.contact != rules_.joint) {
    own = static_cast<std::size_t>(std::ranges::find(rules_.others, e.contact) - rules_.others.begin()) + 1;
    if (own == touching_.size()) return;
  }
  auto& one = touching_[own];
  if (e.kind == EventKind::separation) {
    one = {e.t, true};
    return;
  }
  touch(one, e.contact, e.t, e.kind == EventKind::impact ? e.t + e.duration : nan);
  if (e.t >= rules_.discard && -e.v_n_minus >= rules_.thresholds.impact_speed)
    impacts_.push_back({degrees(e.t), -e.v_n_minus, e.impulse_n, e.contact});
}

void TurnMeter::acceleration(double t, double value) {
  if (t < rules_.discard) return;
  times_.push_back(t);
  acceleration_.push_back(value);
}

void TurnMeter::position(double t, double value) {
  if (t < rules_.discard) return;
  if (first_x_ < 0) first_x_ = std::lround(t * rules_.sampling);
  position_.push_back(value);
}

/// First sample of a whole turn. After the last whole turn: the sample that follows it.
std::size_t TurnMeter::first_of(int whole_turn) const {
  const double spacing = (times_.back() - times_.front()) / static_cast<double>(times_.size() - 1);
  const double begin = times_.front() + whole_turn * turn() - 1e-6 * spacing;
  return static_cast<std::size_t>(std::ranges::lower_bound(times_, begin) - times_.begin());
}

void TurnMeter::flight(TurnMetrics& m, const Flown& flown) const {
  const auto [from, to, contact] = flown;
  const bool turns = rules_.speed != 0;
  Flight f{degrees(from), turns ? std::abs(rules_.speed) * (to - from) * 180 / std::numbers::pi : nan,
           to - from, nan, contact};
  if (f.angle < rules_.thresholds.flight_angle) return;
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

void TurnMeter::peaks(TurnMetrics& m, int turns) const {
  auto& v = m.value;
  double squares = 0;
  const std::size_t all = first_of(turns);
  for (int k = 0; k < turns; ++k) {
    double peak = 0;
    for (auto i = first_of(k), end = first_of(k + 1); i < end; ++i) {
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
  v[TurnMetrics::rms] = std::sqrt(squares / static_cast<double>(all));
}

void TurnMeter::contacts(TurnMetrics& m, double end) const {
  auto& v = m.value;
  const double counted = end - rules_.discard, turns = counted / turn();
  for (const auto& one : flights_) flight(m, one);
  m.impacts = impacts_;
  std::vector<double> losses, returns, durations, decelerations;
  for (const auto& f : m.flights) {
    durations.push_back(f.duration);
    if (std::isfinite(f.deceleration)) decelerations.push_back(f.deceleration);
    if (rules_.speed == 0) continue;
    losses.push_back(f.loss);
    returns.push_back(f.loss + std::copysign(f.angle, rules_.speed));
  }
  double flown = flown_;
  for (const auto& one : touching_)
    if (!std::isnan(one.left_at)) flown += std::max(0.0, end - std::max(one.left_at, rules_.discard));
  if (rules_.speed != 0) {
    v[TurnMetrics::impacts_per_turn] = static_cast<double>(impacts_.size()) / turns;
    v[TurnMetrics::flights_per_turn] = static_cast<double>(m.flights.size()) / turns;
  }
  v[TurnMetrics::flight_share] = flown / (counted * static_cast<double>(touching_.size()));
  v[TurnMetrics::loss_angle] = mean_angle(losses);
  v[TurnMetrics::return_angle] = mean_angle(returns);
  v[TurnMetrics::flight_duration] = mean(durations);
  v[TurnMetrics::deceleration] = mean(decelerations);
}

namespace {

/// A transform for each thread, which keeps chirps and plans of the turns before, because the runs
/// of a study are alike. These depend on the number and spacing of the samples only, so results
/// are bitwise identical to those of a new transform.
TurnTransform& transform_with(int highest) {
  thread_local std::optional<TurnTransform> kept;
  thread_local int of = -1;
  if (of != highest) kept.emplace(highest);
  of = highest;
  return *kept;
}

}  // namespace

void TurnMeter::harmonics(TurnMetrics& m, int turns) const {
  const auto n = times_.size();
  const double spacing = (times_.back() - times_.front()) / static_cast<double>(n - 1);
  double apart = 0;
  bool even = true;
  for (std::size_t i = 1; i < n; ++i) {
    apart = std::max(apart, times_[i] - times_[i - 1]);
    even = even && std::abs(times_[i] - times_[0] - static_cast<double>(i) * spacing) < 1e-4 * spacing;
  }
  const int highest = static_cast<int>(turn() / (2.5 * (even ? spacing : apart)));
  auto& transform = transform_with(highest);
  m.spectrum.assign(static_cast<std::size_t>(highest), 0);
  for (int k = 0; k < turns; ++k) {
    const std::size_t first = first_of(k), count = first_of(k + 1) - first;
    const std::span values(acceleration_.data() + first, count);
    const auto angle = [&](std::size_t i) {
      return rules_.crank_start +
             rules_.speed * (even ? times_[0] + static_cast<double>(i) * spacing : times_[i]);
    };
    Harmonics c;
    if (even) {
      c = transform.even(angle(first), rules_.speed * spacing, values);
    } else {
      std::vector<double> angles;
      for (std::size_t i = first; i < first + count; ++i) angles.push_back(angle(i));
      c = transform.uneven(angles, values);
    }
    for (std::size_t h = 1; h < c.size(); ++h) m.spectrum[h - 1] += 4 * std::norm(c[h]) / turns;
    m.turns.push_back(std::move(c));
  }
  auto& v = m.value;
  const auto mean = mean_of(m.turns);
  m.mean_turn = bin_means(mean, mean_bins);
  double squares = 0;
  for (std::size_t h = 0; h < mean.size(); ++h) squares += (h == 0 ? 1 : 2) * std::norm(mean[h]);
  v[TurnMetrics::mean_turn_rms] = std::sqrt(squares);
  v[TurnMetrics::mean_turn_peak] =
      std::abs(*std::ranges::max_element(m.mean_turn, {}, [](double a) { return std::abs(a); }));
  const bool assessed = !std::isnan(rules_.ideal_maximum);
  v[TurnMetrics::lines] = v[TurnMetrics::lines_total] = assessed ? 0 : nan;
  v[TurnMetrics::line_greatest] = 0;
  for (std::size_t h = 0; h < m.spectrum.size(); ++h) {
    auto& line = m.spectrum[h];
    line = std::sqrt(line);
    if (line >= rules_.thresholds.line_share * rules_.ideal_maximum) {
      ++v[TurnMetrics::lines];
      v[TurnMetrics::lines_total] += line;
    }
    // The first two lines are those of the ideal motion.
    if (h >= 2) v[TurnMetrics::line_greatest] = std::max(v[TurnMetrics::line_greatest], line);
  }
}

/// The last whole turn that begins at crank angle 0; if there is none (a single turn), the last
/// samples.
void TurnMeter::last_turn(TurnMetrics& m) const {
  const std::size_t count = first_of(1);
  const auto turned = [&](std::size_t i) {
    return std::floor((rules_.crank_start + rules_.speed * times_[i]) / (2 * std::numbers::pi));
  };
  std::size_t first = acceleration_.size() - count;
  for (std::size_t i = first; i > 0; --i)
    if (turned(i) != turned(i - 1)) {
      first = i;
      break;
    }
  for (std::size_t i = first; i < first + count; ++i)
    m.last_turn.push_back({degrees(times_[i]), acceleration_[i], i < position_.size() ? position_[i] : nan});
  // The angles increase or decrease, but for one step over 0.
  auto& turn = m.last_turn;
  if (rules_.speed < 0) std::ranges::reverse(turn);
  std::ranges::rotate(turn, std::ranges::min_element(turn, {}, &TracePoint::angle));
  const auto above = [](const TracePoint& a, const TracePoint& b) { return !(a.angle < b.angle); };
  if (std::ranges::adjacent_find(turn, above) != turn.end()) std::ranges::sort(turn, {}, &TracePoint::angle);
}

int whole_turns(std::size_t n, double span, double turn) {
  const auto samples = static_cast<double>(n);
  // There cannot be more turns than samples.
  return static_cast<int>(std::clamp((samples + 1 - 1e-6) * span / (samples - 1) / turn, 0.0, samples));
}

/// Metrics of all included samples, for motions without turns.
void TurnMeter::whole_window(TurnMetrics& m) const {
  double squares = 0, peak = 0;
  for (const double a : acceleration_) {
    squares += a * a;
    peak = std::max(peak, std::abs(a));
  }
  m.value[TurnMetrics::peak_max] = peak;
  m.value[TurnMetrics::ratio_max] = peak / rules_.ideal_maximum;
  m.value[TurnMetrics::rms] = std::sqrt(squares / static_cast<double>(acceleration_.size()));
}

TurnMetrics TurnMeter::finish(double end, double energy_lost) const {
  TurnMetrics m;
  m.value.fill(nan);
  if (end > rules_.discard) {
    if (rules_.joint >= 0) contacts(m, end);
    if (rules_.speed != 0)
      m.value[TurnMetrics::energy_per_turn] = energy_lost * turn() / (end - rules_.discard);
  }
  if (times_.size() < 2) return m;
  if (rules_.speed == 0) {
    whole_window(m);
    return m;
  }
  const int turns = whole_turns(times_.size(), times_.back() - times_.front(), turn());
  if (turns < 1) return m;
  peaks(m, turns);
  harmonics(m, turns);
  last_turn(m);
  return m;
}

}  // namespace freeplay
