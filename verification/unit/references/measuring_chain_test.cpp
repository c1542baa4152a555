// The measuring chain from impacts to statistics, on signals with known values: filter, sampling,
// spectrum, mean revolution, counts. Expected values are closed forms.
#include <catch2/catch.hpp>
#include <random>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "measure/alignment.hpp"
#include "measure/harmonics.hpp"
#include "measure/turns.hpp"
#include "simulation/instrument.hpp"

using namespace freeplay;

namespace {

constexpr double pi = std::numbers::pi;
using Name = TurnMetrics::Name;

struct Line {
  int harmonic;
  double amplitude, phase;
};

double sum(const std::vector<Line>& lines, double phi) {
  double a = 0;
  for (const auto& l : lines) a += l.amplitude * std::cos(l.harmonic * phi + l.phase);
  return a;
}

/// One revolution a second; P samples a revolution, from 0 on.
template <class Signal>
TurnMetrics metrics(double points, int samples, const Signal& signal, double speed = 2 * pi,
                    double crank_start = 0) {
  TurnMeter meter(
      {.speed = speed, .crank_start = crank_start, .thresholds = {}, .ideal_maximum = 10, .joint = -1});
  for (int i = 0; i < samples; ++i) meter.acceleration(i / points, signal(i / points));
  return meter.finish((samples - 1) / points, NAN);
}

ContactEvent event(EventKind kind, double t, double approach = 0, double duration = 0) {
  ContactEvent e;
  e.kind = kind;
  e.t = t;
  e.v_n_minus = -approach;
  e.duration = duration;
  return e;
}

}  // namespace

TEST_CASE("a spectrum has the amplitudes of its signal at any sampling rate", "[chain]") {
  // Linear interpolation between samples gives (sin(πf)/(πf))² of an amplitude: 0.968 at a tenth of
  // the sampling rate, 0.57 at 0.4 of it. Least squares on the samples are exact for frequencies
  // below 0.4 of the sampling rate, to the required residual.
  for (const double points : {36.0, 100.37, 1001.5, 3000.0})
    for (const double speed : {2 * pi, -2 * pi}) {
      CAPTURE(points, speed);
      const auto top = static_cast<int>(points / 2.5), tenth = static_cast<int>(points / 10);
      const std::vector<Line> lines{{1, 3, 0.4}, {2, 0.7, -1}, {tenth, 2, 0.3}, {top, 1, 1.1}};
      const auto m = metrics(
          points, static_cast<int>(3 * points) + 1, [&](double t) { return sum(lines, 0.3 + speed * t); },
          speed, 0.3);
      REQUIRE(m.peaks.size() == 3);
      REQUIRE(m.spectrum.size() == static_cast<std::size_t>(top));
      for (int h = 1; h <= top; ++h) {
        double amplitude = 0;
        for (const auto& l : lines)
          if (l.harmonic == h) amplitude = l.amplitude;
        CAPTURE(h);
        CHECK(std::abs(m.spectrum[h - 1] - amplitude) < 1e-9);
      }
      // Also in the crank's own angle, for either sense of rotation.
      CHECK(std::abs(2.0 * m.turns[1][2] - std::polar(0.7, -1.0)) < 1e-9);
    }
}

TEST_CASE("a mean revolution keeps the part that is common to all revolutions", "[chain]") {
  // Harmonic 1 alone is the same in all revolutions; 3 cos(2πt/3) has a period of three
  // revolutions, is shifted by a third in each, and averages out.
  const auto common = [](double t) { return 2 + 4 * std::cos(2 * pi * t); };
  const auto m = metrics(
      100, 301, [&](double t) { return common(t) + 3 * std::cos(2 * pi * t * (5 + 1.0 / 3)); }, 2 * pi, 0);
  REQUIRE(m.turns.size() == 3);
  // In each revolution the second part is e^{2πik/3} times the same signal, whose mean over three
  // revolutions is zero. Bins of a 720th revolution reduce the first part by (2π/720)²/24.
  CHECK(m.value[TurnMetrics::mean_turn_rms] == Approx(std::sqrt(4 + 8.0)).epsilon(1e-9));
  CHECK(m.value[TurnMetrics::mean_turn_peak] == Approx(6).epsilon(1e-5));
  CHECK(m.value[TurnMetrics::rms] > 4);
}

TEST_CASE("unevenly spaced samples give the same spectrum", "[chain]") {
  TurnMeter meter({.speed = 2 * pi, .thresholds = {}, .ideal_maximum = 10, .joint = -1});
  const std::vector<Line> lines{{1, 3, 0.4}, {5, 0.7, -1}, {25, 1, 1.1}};
  // Samples shifted by up to a quarter of their distance, so at most 1.5 of it apart: harmonics
  // below 0.4·100/1.5 are found.
  for (int i = 0; i < 201; ++i) {
    const double t = (i + 0.25 * std::sin(7.0 * i)) / 100;
    meter.acceleration(t, sum(lines, 2 * pi * t));
  }
  const auto m = meter.finish(2, NAN);
  for (const auto& l : lines) CHECK(std::abs(m.spectrum[l.harmonic - 1] - l.amplitude) < 1e-9);
}

TEST_CASE("an impact just before a sample does not delay the sample", "[chain]") {
  // Steps end where impacts are located; a sample that is due after one, however soon, is taken at
  // its instant.
  Instrument settings;
  settings.sampling = 1e4;
  for (const double before : {0.0, 1e-15, 1e-12, 9e-12, 1e-10, 1e-7, -9e-12}) {
    Channel channel(settings);
    channel.begin(0, true);
    std::vector<double> samples;
    const double in_impact = 2e-4 - before;
    const auto feed = [&](double from, double to) {
      channel.pieces(from, to, [&](double t, double end) {
        if (channel.feed(t, end, 0, 0)) samples.push_back(end);
      });
    };
    feed(0, in_impact);
    feed(in_impact, 5e-4);
    CAPTURE(before);
    REQUIRE(samples.size() == 5);
    for (int i = 0; i < 5; ++i)
      CHECK(std::abs(samples[static_cast<std::size_t>(i)] - 1e-4 * (i + 1)) <= 1e-13);
  }
}

TEST_CASE("harmonics of many unevenly spaced samples agree with sums in long double", "[chain]") {
  // 2,000 samples moved by up to a quarter of their distance, harmonics up to 533 = 0.4·2,000/1.5,
  // many revolutions away from zero: the signal is
  // that of its lines to the rounding of angles (1e-16 of 600 rad, times 533).
  const int n = 2000, highest = 533;
  std::vector<double> angles, values;
  std::mt19937 engine(4);
  std::uniform_real_distribution<double> uniform(-1, 1);
  std::vector<std::complex<long double>> expected(highest + 1);
  for (auto& c : expected) c = {uniform(engine), uniform(engine)};
  expected[0] = 0.5L;
  for (int j = 0; j < n; ++j) {
    angles.push_back(-600 + 2 * pi * (j + 0.25 * uniform(engine)) / n);
    long double value = expected[0].real();
    for (int k = 1; k <= highest; ++k)
      value += 2 * (expected[k] * std::polar(1.0L, static_cast<long double>(k) * angles.back())).real();
    values.push_back(static_cast<double>(value));
  }
  TurnTransform transform(highest);
  const auto found = transform.uneven(angles, values);
  double worst = 0;
  for (int k = 0; k <= highest; ++k)
    worst = std::max(worst, std::abs(found[k] - static_cast<std::complex<double>>(expected[k])));
  CHECK(worst < 1e-9);
}

TEST_CASE("a mean revolution is the mean of its bins, also with fewer samples than bins", "[chain]") {
  // The mean over a bin from a to b of cos(kφ + ε): (sin(kb + ε) − sin(ka + ε))/(k(b − a)).
  const std::vector<Line> lines{{1, 26, 0.4}, {2, 4, -1}, {14, 1, 2}};
  for (const double points : {36.0, 36.4, 720.0, 2000.3}) {
    CAPTURE(points);
    const auto m =
        metrics(points, static_cast<int>(5 * points), [&](double t) { return sum(lines, 2 * pi * t); });
    double worst = 0, squares = 0;
    for (int b = 0; b < mean_bins; ++b) {
      const double from = 2 * pi * b / mean_bins, to = 2 * pi * (b + 1) / mean_bins;
      double mean = 0;
      for (const auto& l : lines)
        mean += l.amplitude * (std::sin(l.harmonic * to + l.phase) - std::sin(l.harmonic * from + l.phase)) /
                (l.harmonic * (to - from));
      worst = std::max(worst, std::abs(m.mean_turn[b] - mean));
      squares += std::pow(m.mean_turn[b], 2) / mean_bins;
    }
    CHECK(worst < 1e-9);
    CHECK(std::sqrt(squares) == Approx(std::sqrt((26 * 26 + 16 + 1) / 2.0)).epsilon(1e-3));
  }
}

TEST_CASE("known impulses pass through filter, sampling and spectrum with the exact amplitudes", "[chain]") {
  // Impulses dv once a revolution T: a(t) = dv Σ δ(t − nT) has lines 2 dv/T, and through a
  // Butterworth of order n
  //     2 dv/T / √(1 + (kf/f_c)^(2n));
  // aliases in the lines come from beyond 0.6 of the sampling rate, at 24 f_c: 24⁻⁶ of the
  // amplitudes.
  constexpr double dv = 0.03, T = 0.3, sampling = 10001.5, cut = sampling / 40;
  constexpr int order = 6, turns = 4;
  LowPass filter(cut, order);
  filter.reset(0);
  // In the discarded time 250 Hz settle to e^(−2π·250·0.26·0.3) = 1e-53.
  TurnMeter meter({.discard = T, .speed = 2 * pi / T, .thresholds = {}, .ideal_maximum = 1, .joint = -1});
  double t = 0, next = 0;
  double kick = 0.1 * T;
  while (t < (turns + 1) * T) {
    const double to = std::min(next, kick);
    if (to > t) filter.advance(to - t, 0);
    t = to;
    if (t == kick) filter.add_jump(dv), kick += T;
    if (t == next) {
      meter.acceleration(t, filter.output());
      next += 1 / sampling;
    }
  }
  const auto m = meter.finish(t, NAN);
  REQUIRE(m.peaks.size() == turns);
  double worst = 0;
  for (std::size_t h = 1; h <= m.spectrum.size(); ++h) {
    const double f = static_cast<double>(h) / T;
    worst = std::max(
        worst, std::abs(m.spectrum[h - 1] / (2 * dv / T) - 1 / std::sqrt(1 + std::pow(f / cut, 2 * order))));
  }
  CHECK(worst < 1e-7);
  // The signal's mean over a revolution is dv/T, its power Parseval's sum of the lines.
  CHECK(m.turns[0][0].real() == Approx(dv / T).epsilon(1e-7));
  double power = std::pow(dv / T, 2);
  for (int k = 1; k < 3000; ++k)
    power += 0.5 * std::pow(2 * dv / T, 2) / (1 + std::pow(k / T / cut, 2 * order));
  // There are 3000.45 samples per revolution: 3000 or 3001 of them, so their mean power is that of
  // the revolution within a relative error of 1/3000.
  CHECK(m.value[Name::rms] == Approx(std::sqrt(power)).epsilon(1e-3));
}

TEST_CASE("counts per revolution refer to the time that was counted", "[chain]") {
  TurnMeter meter({.discard = 1, .speed = 2 * pi, .thresholds = {}});
  // Flights of 0.15 s from n/5 on, each ended by an impact: none is under way at 1 s, and 1.9 s
  // contain 9.5 fifths.
  for (int n = 0; 0.2 * n < 2.9; ++n) {
    meter.event(event(EventKind::separation, 0.2 * n + 0.02));
    if (0.2 * n + 0.17 < 2.9) meter.event(event(EventKind::contact, 0.2 * n + 0.17, 1));
  }
  const auto m = meter.finish(2.9, 0.38);
  CHECK(m.value[Name::impacts_per_turn] == Approx(9 / 1.9));
  CHECK(m.value[Name::flights_per_turn] == Approx(9 / 1.9));
  CHECK(m.value[Name::flight_share] ==
        Approx((9 * 0.15 + 0.08) / 1.9));  // from 2.82 s on the last one is under way
  CHECK(m.value[Name::energy_per_turn] == Approx(0.2));
  // Two revolutions of 1001.5 samples have 2003, or 2002 where they begin between samples.
  const auto wave = [](double t) { return std::cos(2 * pi * t); };
  CHECK(metrics(1001.5, 2003, wave).peaks.size() == 2);
  CHECK(metrics(1001.5, 1001, wave).peaks.size() == 1);
  CHECK(metrics(36, 36, wave).peaks.size() == 1);
  CHECK(metrics(36, 71, wave).peaks.size() == 1);
}

TEST_CASE("flights and contacts across the ends of the window count with their part inside it", "[chain]") {
  const TurnRules rules{.discard = 1, .speed = 2 * pi, .thresholds = {}};
  SECTION("a flight across both ends of the window") {
    TurnMeter meter(rules);
    meter.event(event(EventKind::separation, 0.9));
    meter.event(event(EventKind::impact, 1.2, 1, 0.1));
    const auto m = meter.finish(2, 0);
    CHECK(m.value[Name::flight_share] == Approx(0.2 + 0.7));
    CHECK(m.value[Name::flights_per_turn] == 1);
    CHECK(m.value[Name::flight_duration] == Approx(0.3));
    CHECK(m.value[Name::loss_angle] == Approx(324));
    CHECK(m.value[Name::return_angle] == Approx(72));
  }
  SECTION("a contact that is open during the whole window") {
    TurnMeter meter(rules);
    meter.event(event(EventKind::contact, 0));
    CHECK(meter.finish(2, 0).value[Name::flight_share] == 0);
  }
  SECTION("a run that starts in flight") {
    TurnMeter meter({.speed = 2 * pi, .thresholds = {}});
    meter.event(event(EventKind::contact, 0.5, 1));
    const auto m = meter.finish(2, 0);
    CHECK(m.value[Name::flight_share] == Approx(0.25));
    CHECK(m.flights.empty());  // the angle of separation is unknown
  }
}

TEST_CASE("a crank that turns backwards has its own angles of separation and contact", "[chain]") {
  for (const double sign : {1.0, -1.0}) {
    TurnMeter meter({.speed = sign * 2 * pi, .crank_start = sign * pi / 6, .thresholds = {}});
    for (int turn = 0; turn < 3; ++turn) {
      meter.event(event(EventKind::separation, turn + 0.25));
      meter.event(event(EventKind::impact, turn + 0.5, 1));
    }
    const auto m = meter.finish(3, 0);
    CHECK(m.value[Name::loss_angle] == Approx(whole_circle(sign * 120)));
    CHECK(m.value[Name::return_angle] == Approx(whole_circle(sign * 210)));
    CHECK(m.impacts[0].angle == Approx(whole_circle(sign * 210)));
  }
}
