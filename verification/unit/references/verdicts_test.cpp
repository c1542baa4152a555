// From statistics to verdicts, on synthetic measurements with known verdicts: the verdict of
// validate, and reading of files.
#include "measure/alignment.hpp"
#include "measure/measurement.hpp"
#include "simulation/statistics.hpp"
#include "study/calibration/validate.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;
using Catch::Matchers::Contains;

namespace {

constexpr double pi = std::numbers::pi;

/// The slider's acceleration, λ = 1/6, and an impact's ringing.
double curve(double phi) {
  return 20 * std::cos(phi) + 20.0 / 6 * std::cos(2 * phi) + 2 * std::cos(9 * phi - 0.3);
}

/// Revolutions at one a second, with `points` samples each, that vary as a whole by ±`scatter`
/// of their size.
template <class Signal>
TurnMetrics turns(double points, double scatter, const Signal& signal, int count = 4) {
  TurnMeter meter({.speed = 2 * pi, .thresholds = {}, .ideal_maximum = 25, .joint = -1});
  for (int i = 0; i < static_cast<int>(count * points) + 1; ++i) {
    const double t = i / points, sign = static_cast<int>(t + 1e-9) % 2 ? 1 : -1;
    meter.acceleration(t, (1 + sign * scatter) * signal(2 * pi * t));
  }
  return meter.finish(count, NAN);
}

template <class Signal>
Agreement assessed(double uncertainty, bool datum, const Signal& signal, double scatter = 0.01,
                   int count = 4) {
  Agreement a;
  a.metrics = turns(400, scatter, curve, count);
  assess(turns(60, scatter, signal, count), uncertainty, datum, a);
  return a;
}

TurnMetrics metered(const Measurement& m, const TurnRules& rules) {
  TurnMeter meter(rules);
  for (std::size_t i = 0; i < m.time.size(); ++i) meter.acceleration(m.time[i], m.acceleration[i]);
  return meter.finish(m.time.back(), NAN);
}

/// m/s², of curve().
const double rms = std::sqrt((400 + 400.0 / 36 + 4) / 2);

}  // namespace

TEST_CASE("a measurement made from the model agrees with it at another sampling rate", "[chain][validate]") {
  const auto a = assessed(0, true, curve);
  CHECK(a.sign == 1);
  CHECK(a.sign_decided);
  CHECK(a.gain.mean == Approx(1).epsilon(1e-9));
  // Gains 0.99, 1.01, 0.99, 1.01 of both: √(4·0.01²/(4·3)) of each mean.
  CHECK(a.gain.high - a.gain.mean == Approx(1.96 * 0.01 * std::sqrt(2.0 / 3)).epsilon(1e-6));
  CHECK(std::abs(a.phase.mean) < 1e-7);
  for (const auto& p : a.properties) CHECK(p.difference.size < 1e-7);
  const auto& wave = a.properties[Agreement::waveform].difference;
  CHECK(wave.expected == Approx(0.01 * rms * std::sqrt(2.0 / 3)).epsilon(1e-6));
  // One direction, three degrees of freedom of each sample: F(1, 6) at 1 % is 13.745.
  CHECK(wave.limit == Approx(wave.expected * std::sqrt(13.745)).epsilon(1e-4));
  CHECK(a.verdict == Agreement::Verdict::agrees);
}

TEST_CASE("sign, gain and phase are reported and not removed", "[chain][validate]") {
  const auto reversed = assessed(0, false, [](double phi) { return -curve(phi); });
  CHECK(reversed.sign == -1);
  CHECK(reversed.sign_decided);
  CHECK(std::abs(reversed.phase.mean) < 1e-7);  // not the 180° that gives nearly the same fit
  CHECK(reversed.properties[Agreement::waveform].difference.size == Approx(2 * rms).epsilon(1e-9));
  CHECK(reversed.verdict == Agreement::Verdict::differs);
  CHECK(reversed.faulty_signal);
  CHECK_THAT(reversed.findings.at(0), Contains("opposite"));

  const auto larger = assessed(0, false, [](double phi) { return 1.1 * curve(phi); });
  CHECK(larger.gain.mean == Approx(1.1).epsilon(1e-9));
  CHECK(larger.properties[Agreement::waveform].difference.size == Approx(0.1 * rms).epsilon(1e-9));
  CHECK(larger.properties[Agreement::peaks].difference.size == Approx(std::log(1.1)).epsilon(1e-9));
  // The revolutions vary by ±1 % of their size, and powers are averaged.
  CHECK(larger.properties[Agreement::spectrum].difference.size ==
        Approx(0.1 * rms * std::hypot(1, 0.01)).epsilon(1e-9));
  CHECK_THAT(larger.findings.at(0), Contains("1.1 (") && Contains("times the model's"));

  const auto late = [](double phi) { return curve(phi - 20 * pi / 180); };
  const auto with_datum = assessed(0, true, late), without = assessed(0, false, late);
  for (const auto* a : {&with_datum, &without}) CHECK(a->phase.mean == Approx(20).epsilon(1e-9));
  CHECK(with_datum.verdict == Agreement::Verdict::differs);
  CHECK_THAT(with_datum.findings.at(0), Contains("20° ("));
  CHECK(with_datum.properties[Agreement::peak_angles].difference.size ==
        Approx(2 * std::sin(10 * pi / 180)).epsilon(1e-4));  // the chord of 20°
  // A file of times contains no phase: the model is shifted, and reports it.
  CHECK(without.moved == Approx(20).epsilon(1e-9));
  CHECK(without.properties[Agreement::waveform].difference.size < 1e-7);
  CHECK(without.verdict == Agreement::Verdict::agrees);
}

TEST_CASE("a constant offset of the measured signal is named apart from the waveform", "[chain][validate]") {
  const auto offset = [](double phi) { return curve(phi) + 0.5; };
  // 0.5 is beyond the limit of 0.1 (2.576 times, one direction), not of 1.
  const auto sure = assessed(0.1, true, offset, 0), unsure = assessed(1, true, offset, 0);
  CHECK(sure.shift == Approx(0.5).epsilon(1e-9));
  CHECK(sure.properties[Agreement::waveform].difference.size < 1e-7);
  CHECK(sure.properties[Agreement::offset].difference.limit == Approx(0.2576).epsilon(1e-3));
  CHECK(sure.verdict == Agreement::Verdict::differs);
  CHECK(sure.faulty_signal);
  CHECK_THAT(sure.findings.at(0), Contains("constant offset of 0.5 m/s²"));
  CHECK(unsure.verdict == Agreement::Verdict::agrees);
  REQUIRE(unsure.remarks.size() == 1);
  CHECK_THAT(unsure.remarks[0], Contains("constant offset of 0.5 m/s²") && Contains("within"));
}

TEST_CASE("an offset below the judged size is named if it is beyond its uncertainty", "[chain][validate]") {
  // 0.2 is below 2 % of the rms of 14.4, and beyond the limit of 2.576 * 0.05.
  const auto offset = [](double phi) { return curve(phi) + 0.2; };
  REQUIRE(0.2 < 0.02 * rms);
  const auto small = assessed(0.05, true, offset, 0), within = assessed(0.1, true, offset, 0);
  CHECK(small.small_offset());
  CHECK(small.verdict == Agreement::Verdict::agrees);
  REQUIRE(small.remarks.size() == 1);
  CHECK_THAT(small.remarks[0],
             Contains("constant offset of 0.2 m/s²") && Contains("error 0.05") && Contains("not judged"));
  CHECK(!within.small_offset());
  CHECK(within.remarks.empty());
  // Rounding is no offset, although a signal without scatter has no error.
  CHECK(!assessed(0, true, curve, 0).small_offset());
}

TEST_CASE("a constant offset has the standard error of the mean of revolutions", "[chain][validate]") {
  // Revolutions whose means are 10 ± 0.3, alternating: of n = 20, 0.3/√19, since Σ r² = n 0.09 and
  // their autocorrelation, negative in the first pair of lags, does not lengthen the error.
  const auto signal = [](double phi) {
    return curve(phi) + 10 + (static_cast<int>(phi / (2 * pi) + 1e-9) % 2 ? 0.3 : -0.3);
  };
  const auto measured = turns(60, 0, signal, 20);
  const auto alone = offset_from(0, measured, 0), known = offset_from(4, measured, 0.5);
  CHECK(alone.value == Approx(10).epsilon(1e-9));
  CHECK(alone.error == Approx(0.3 / std::sqrt(19)).epsilon(1e-6));
  CHECK(alone.beyond());
  CHECK(known.value == Approx(6).epsilon(1e-9));
  CHECK(known.error == Approx(std::hypot(0.5, 0.3 / std::sqrt(19))).epsilon(1e-6));
  CHECK(known.beyond());
  CHECK(!offset_from(9.5, measured, 0.5).beyond());  // 0.5 against 2.576 * 0.5
  // One revolution without uncertainty decides nothing.
  const auto one = offset_from(0, turns(60, 0, signal, 1), 0);
  CHECK(std::isnan(one.error));
  CHECK(!one.beyond());
}

TEST_CASE("the uncertainty of a measured file decides whether a difference is significant",
          "[chain][validate]") {
  // A gain of 1.04 is beyond an uncertainty of 1 % of the curve (4 % > 2.576 %), and within 5 %.
  const auto larger = [](double phi) { return 1.04 * curve(phi); };
  CHECK(assessed(0.01 * rms, true, larger, 0).gain.low > 1);
  CHECK(assessed(0.01 * rms, true, larger, 0).verdict == Agreement::Verdict::differs);
  CHECK(assessed(0.05 * rms, true, larger, 0).verdict == Agreement::Verdict::agrees);
}

TEST_CASE("peaks, their angles and the spectrum are compared beside the mean revolution",
          "[chain][validate]") {
  // Ringing that changes its sign with each revolution has no mean: 3 cos 19φ beside the curve.
  const auto ringing = [](double phi) {
    return curve(phi) + (static_cast<int>(phi / (2 * pi) + 1e-9) % 2 ? 3 : -3) * std::cos(19 * phi);
  };
  const auto a = assessed(0, true, ringing, 0, 20);
  CHECK(a.properties[Agreement::waveform].difference.size < 1e-7);
  CHECK_FALSE(a.properties[Agreement::waveform].differs());
  // The octave of harmonics 16 to 31 has an amplitude of 3/√2, the model none.
  CHECK(a.properties[Agreement::spectrum].difference.size == Approx(3 / std::sqrt(2.0)).epsilon(1e-9));
  CHECK(a.verdict == Agreement::Verdict::differs);
  CHECK_THAT(a.findings.back(), Contains("harmonics 16 to 31"));
  // A pulse in the other half of the revolution moves the peaks there: −33 m/s² near 3 rad for 25 m/s² at 0.
  const auto pulse = [](double phi) { return curve(phi) - 14 * std::exp(20 * (std::cos(phi - 3) - 1)); };
  const auto b = assessed(0, true, pulse, 0.01, 20);
  CHECK(b.properties[Agreement::peak_angles].differs());
  CHECK(b.properties[Agreement::peaks].differs());
}

TEST_CASE("one measured revolution without uncertainty decides nothing", "[chain][validate]") {
  Agreement a;
  a.metrics = turns(400, 0.01, curve);
  assess(turns(60, 0, curve, 1), 0, true, a);
  CHECK(a.verdict == Agreement::Verdict::undecided);
  CHECK(std::isnan(a.properties[Agreement::waveform].difference.limit));
}

TEST_CASE("a motion that changes with time is not stationary", "[chain][validate]") {
  CHECK(unsteadiness(turns(60, 0.01, curve, 20), 0) == 0);
  // From half time on 1.1 times as large: halves differ by a tenth of the rms.
  const auto growing = [](double phi) { return (phi < 20 * pi ? 1 : 1.1) * curve(phi); };
  CHECK(unsteadiness(turns(60, 0, growing, 20), 0) == Approx(0.1 * rms).epsilon(1e-6));
  CHECK(unsteadiness(turns(60, 0, growing, 20), 0.1 * rms) == 0);
}

TEST_CASE("a model passes only if the test finds half and twice the clearance", "[chain][validate]") {
  const auto judged = [](const std::vector<double>& found) {
    std::vector<ClearanceTrial> trials;
    for (const double f : trial_factors)
      trials.push_back(
          {"joints.pin.clearance", 1e-4, f, "penalty", true, std::ranges::find(found, f) != found.end()});
    Agreement a;
    a.verdict = Agreement::Verdict::agrees;
    assess_power(trials, a);
    return a;
  };
  const auto sharp = judged({0.5, 0.8, 0.9, 1.2, 1.5, 2});
  CHECK(sharp.verdict == Agreement::Verdict::agrees);
  CHECK(sharp.power ==
        "the same test finds joints.pin.clearance from 1.2 times (0.12 mm) and up to 0.9 times "
        "(0.09 mm) of its value");
  // A factor that is found within others that are not does not count.
  CHECK_THAT(judged({0.5, 1.1, 1.5, 2}).power, Contains("from 1.5 times (0.15 mm) and up to 0.5 times"));
  const auto one_sided = judged({1.5, 2});
  CHECK(one_sided.verdict == Agreement::Verdict::undecided);
  CHECK_THAT(one_sided.power, Contains("from 1.5 times (0.15 mm), but no smaller one"));
  const auto blind = judged({});
  CHECK(blind.verdict == Agreement::Verdict::undecided);
  CHECK_THAT(blind.power, Contains("also accepts half or twice joints.pin.clearance"));
}

TEST_CASE("peaks of model and measurement are compared at one sampling rate", "[chain][validate][slow]") {
  // A run of the rig, with every fifth sample as the measurement: with the same samples of the
  // model the ratio is 1 to the last digit of the file; with the instrument's sampling rate it
  // includes the peaks between them.
  test::TemporaryFolder folder;
  const auto file = test::source_folder() / "cases/flores2011-experiment/guide.toml";
  const std::vector<std::string> short_run{"run.revolutions=4", "run.discard=1",
                                           "instruments.accelerometer.sampling=10000"};
  const auto make = [&](int every) {
    Study study;
    study.file = study.scene = file;
    study.accelerometer = "accelerometer";
    study.joints = {"gudgeon"};
    study.length.discard = 1;
    return run_case(study, Case{"", "nonsmooth", {}, 0, 4, file, short_run, every > 1 ? 10000.0 / every : 0},
                    {});
  };
  const auto fine = make(1), coarse = make(5);
  REQUIRE(fine.metrics.peaks.size() == coarse.metrics.peaks.size());
  for (std::size_t k = 0; k < fine.metrics.peaks.size(); ++k)
    CHECK(coarse.metrics.peaks[k] <= fine.metrics.peaks[k]);
  CHECK(coarse.metrics.value[TurnMetrics::rms] == Approx(fine.metrics.value[TurnMetrics::rms]).epsilon(0.02));
  CHECK(coarse.metrics.spectrum.size() == fine.metrics.spectrum.size() / 5);
  // With N samples a revolution the first harmonic contains those beside N, 2N, … as aliases.
  const std::size_t samples = 600;  // 2 kHz at 200 rpm
  double folded = 0;
  for (std::size_t beside = samples; beside < fine.metrics.spectrum.size(); beside += samples)
    folded += fine.metrics.spectrum[beside - 2] + fine.metrics.spectrum[beside];
  CHECK(folded < 0.02 * fine.metrics.spectrum[0]);
  CHECK(std::abs(coarse.metrics.spectrum[0] - fine.metrics.spectrum[0]) < 1.01 * folded);
}

TEST_CASE("samples of a file have the given times, within their digits and for both directions of the crank",
          "[chain]") {
  test::TemporaryFolder folder;
  const auto read = [&](const std::string& text, double speed) {
    write_file(folder.path() / "data.csv", text);
    return read_measurement(folder.path() / "data.csv", speed, 0);
  };
  // 1001.5 Hz with four decimals: rounding, not unevenness.
  std::string text = "t,acceleration\n";
  for (int i = 0; i < 2004; ++i) text += fmt::format("{:.4f},{}\n", i / 1001.5, curve(2 * pi * i / 1001.5));
  const auto even = read(text, 2 * pi);
  CHECK(even.sampling == Approx(1001.5).epsilon(1e-4));
  for (std::size_t i = 0; i < even.time.size(); ++i)
    CHECK(even.time[i] == Approx(static_cast<double>(i) * even.time[1]).epsilon(1e-12));
  CHECK_FALSE(even.datum);
  // The value at an angle is the value at that angle, for either sense of the crank and the lines.
  for (const double speed : {2 * pi, -2 * pi})
    for (const int way : {1, -1}) {
      CAPTURE(speed, way);
      text = "crank_angle,acceleration\n";
      for (int i = 0; i < 150; ++i) {
        const double degrees = whole_circle(100 + way * 3.6 * i);
        text += fmt::format("{:.1f},{}\n", degrees, curve(degrees * pi / 180));
      }
      const auto m = read(text, speed);
      const auto metrics = metered(m, {.speed = speed,
                                       .crank_start = m.start_angle * pi / 180,
                                       .thresholds = {},
                                       .ideal_maximum = 25,
                                       .joint = -1});
      CHECK(m.datum);
      CHECK(std::abs(2.0 * metrics.turns[0][1] - 20.0) < 1e-9);
      CHECK(std::abs(2.0 * metrics.turns[0][9] - std::polar(2.0, -0.3)) < 1e-9);
    }
}

TEST_CASE("a file shorter than one revolution is refused, one of a whole revolution is accepted",
          "[chain][validate]") {
  // 5,000 samples a revolution: a whole revolution ends before the first sample of the next.
  test::TemporaryFolder folder;
  const auto file = folder.path() / "data.csv";
  for (const int samples : {4990, 4996, 4998, 4999, 5000, 5001}) {
    std::string text = "t,acceleration\n";
    for (int i = 0; i < samples; ++i)
      text += fmt::format("{:.7f},{}\n", i / 5000.0, curve(2 * pi * i / 5000.0));
    write_file(file, text);
    CAPTURE(samples);
    if (samples < 5000) {
      CHECK_THROWS_WITH(read_measurement(file, 2 * pi, 0), Contains("less than a turn"));
      continue;
    }
    const auto m = read_measurement(file, 2 * pi, 0);
    CHECK(metered(m, {.speed = 2 * pi, .thresholds = {}, .joint = -1}).turns.size() == 1);
  }
}

TEST_CASE("the part that repeats in each revolution decides the sign; without it the sign stays undecided",
          "[chain][validate]") {
  // The crank's motion in harmonics 1 and 2, and independent impacts in each revolution: 117
  // harmonics with twenty times the power of the second. Only the second harmonic distinguishes the
  // sign from a shift by half a revolution.
  std::mt19937_64 engine(4);
  std::normal_distribution<double> normal;
  const auto turn = [&](double sign) {
    Harmonics c(200);
    c[1] = sign * 10.0;
    c[2] = sign * std::polar(10.0 / 6, 0.5);
    for (std::size_t k = 3; k < 120; ++k) c[k] += std::complex<double>(normal(engine), normal(engine)) * 0.7;
    for (std::size_t k = 1; k < 3; ++k) c[k] += std::complex<double>(normal(engine), normal(engine)) * 0.3;
    return c;
  };
  std::vector<Harmonics> model, same, reversed;
  for (int i = 0; i < 20; ++i)
    model.push_back(turn(1)), same.push_back(turn(1)), reversed.push_back(turn(-1));
  for (const auto* list : {&same, &reversed}) {
    const auto a = align(*list, model);
    CHECK(a.decided);
    CHECK(a.sign == (list == &same ? 1 : -1));
    CHECK(std::abs(a.phase) < 4 * a.phase_error);
    CHECK(std::abs(a.gain - 1) < 4 * a.gain_error);
    CHECK(a.gain_error < 0.05);
  }
  // A single harmonic cannot distinguish a reversed curve from one shifted by half a revolution.
  const Harmonics cosine{0, 1.0}, opposite{0, -1.0};
  const auto a = align({opposite, opposite}, {cosine, cosine});
  CHECK_FALSE(a.decided);
  CHECK(a.sign == 1);
  CHECK(std::abs(a.phase) == Approx(pi));
}

TEST_CASE("outlying revolutions at the start of a measurement are found, and a later one",
          "[chain][validate]") {
  // Revolutions of 0.99 to 1.01 times a curve, in equal steps, of which some are `size` times as great.
  // Their distances from the median are 0.1 % to 1 % of the rms, half of them below 0.6 %, and size − 1.
  const auto found = [](const std::vector<int>& great, double size, int count = 12) {
    const auto signal = [&](double phi) {
      const int turn = static_cast<int>(phi / (2 * pi) + 1e-9);
      const bool is_great = std::ranges::find(great, turn) != great.end();
      return (is_great ? size : 1) * (1 + 0.01 * (5 * turn % 12 - 5.5) / 5.5) * curve(phi);
    };
    return outlying_turns(turns(60, 0, signal, count));
  };
  CHECK(found({}, 1).start == 0);
  CHECK(found({}, 1).single < 0);
  const auto first = found({0}, 1.5);
  CHECK(first.start == 1);
  CHECK(first.single < 0);
  CHECK(first.ratio > 50);
  CHECK(first.ratio < 200);
  CHECK(found({0, 1, 2}, 1.5).start == 3);
  // More than a quarter is no start.
  CHECK(found({0, 1, 2, 3}, 1.5).start == 0);
  const auto later = found({5}, 1.5);
  CHECK(later.start == 0);
  CHECK(later.single == 5);
  // Three times the median and twice the greatest of the others are needed: 1.5 % are scatter.
  CHECK(found({0}, 1.015).start == 0);
  CHECK(found({0}, 1.05).start == 1);
  CHECK(found({0}, 1.5, 7).start == 0);
}

TEST_CASE("an outlying start would explain any difference", "[chain][validate]") {
  // A model that is 10 % too great differs from twelve revolutions with a scatter of 1 %, but not if the
  // first one is five times as great.
  const auto judged = [](bool outlier) {
    Agreement a;
    a.metrics = turns(
        400, 0.01, [](double phi) { return 1.1 * curve(phi); }, 12);
    const auto signal = [&](double phi) { return (outlier && phi < 2 * pi - 1e-9 ? 5 : 1) * curve(phi); };
    assess(turns(60, 0.01, signal, 12), 0, true, a);
    return a.properties[Agreement::waveform].differs();
  };
  CHECK(judged(false));
  CHECK(!judged(true));
}
