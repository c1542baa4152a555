#include "study/calibration/agreement.hpp"

#include <fmt/format.h>

#include <bit>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <utility>

#include "measure/alignment.hpp"
#include "measure/measurement.hpp"
#include "mechanism/scene.hpp"
#include "study/calibration/misfit.hpp"
#include "study/runs/turns.hpp"

namespace freeplay {

std::string unit_plausibility(const TurnMetrics& measured, const TurnMetrics& ideal) {
  const auto low = [](const TurnMetrics& m) {
    double squares = 0;
    for (std::size_t h = 0; h < std::min<std::size_t>(3, m.spectrum.size()); ++h)
      squares += m.spectrum[h] * m.spectrum[h];
    return std::sqrt(squares);
  };
  const double a = low(measured), b = low(ideal);
  if (!(a > 0 && b > 0)) return "";
  struct Unit {
    const char* name;
    double size;  // m/s²
  };
  for (const auto& unit : {Unit{"g", 9.80665}, {"cm/s²", 0.01}, {"mm/s²", 0.001}})
    if (std::abs(std::log(b / a / unit.size)) < std::log(4.0 / 3))
      return fmt::format(
          "the first three harmonics of the measured acceleration are {:.4g} m/s², those of the ideal "
          "mechanism {:.4g} m/s², {:.3g} times as much; is the file in {} instead of m/s²?",
          a, b, b / a, unit.name);
  return "";
}

namespace {

constexpr double to_degrees = 180 / std::numbers::pi;

/// Vectors of each property, one for each turn.
struct Features {
  std::array<Samples, Agreement::count> of;
  double peak = 0;    // m/s², mean
  double spread = 0;  // mean chord from the peak to any angle with |a| ≥ peak − 2u
};

/// Number of octaves of the harmonics below `count`: 1, 2 to 3, 4 to 7, …
std::size_t octaves(std::size_t count) { return std::bit_width(count - 1); }

Features features(const std::vector<Harmonics>& turns, std::size_t count, double moved_by,
                  double uncertainty) {
  Features f;
  const auto size = std::bit_ceil(4 * count);
  Eigen::FFT<double> fft;
  for (const auto& turn : turns) {
    auto c = moved(turn, moved_by);
    c.resize(count);
    f.of[Agreement::offset].push_back({c[0].real()});
    auto& wave = f.of[Agreement::waveform].emplace_back();
    auto& bands = f.of[Agreement::spectrum].emplace_back(octaves(count));
    for (std::size_t k = 1; k < count; ++k) {
      wave.push_back(std::numbers::sqrt2 * c[k].real());
      wave.push_back(std::numbers::sqrt2 * c[k].imag());
      bands[std::bit_width(k) - 1] += 2 * std::norm(c[k]);
    }
    // |a| on a grid that resolves the highest harmonic.
    std::vector<std::complex<double>> terms(size), values;
    for (std::size_t k = 0; k < count; ++k) terms[k] = (k == 0 ? 1.0 : 2.0) * c[k];
    fft.inv(values, terms);
    std::vector<double> a;
    for (const auto& z : values) a.push_back(std::abs(z.real()) * static_cast<double>(size));
    const auto best = std::ranges::max_element(a) - a.begin();
    const auto at = [&](std::ptrdiff_t i) { return a[static_cast<std::size_t>(i) % size]; };
    const auto grid = static_cast<std::ptrdiff_t>(size);
    const double before = at(best + grid - 1), after = at(best + 1), bend = before - 2 * at(best) + after;
    const double off = bend < 0 ? 0.5 * (before - after) / bend : 0,
                 cell = 2 * std::numbers::pi / static_cast<double>(size);
    const double peak = at(best) - 0.25 * (before - after) * off,
                 angle = cell * (static_cast<double>(best) + off);
    f.of[Agreement::peaks].push_back({std::log(peak)});
    f.of[Agreement::peak_angles].push_back({std::cos(angle), std::sin(angle)});
    double chord = 0;
    for (std::ptrdiff_t i = 0; i < grid; ++i)
      if (at(i) >= peak - 2 * uncertainty)
        chord = std::max(chord, 2 * std::abs(std::sin(0.5 * (cell * static_cast<double>(i) - angle))));
    f.peak += peak / static_cast<double>(turns.size());
    f.spread += (uncertainty > 0 ? chord : 0) / static_cast<double>(turns.size());
  }
  return f;
}

std::vector<double> mean_of(const Samples& x) {
  std::vector<double> mean(x.front().size());
  for (const auto& one : x)
    for (std::size_t i = 0; i < mean.size(); ++i) mean[i] += one[i] / static_cast<double>(x.size());
  return mean;
}

/// Makes differences of the octaves' powers differences of amplitudes, A − B = (A² − B²)/(A + B).
/// Returns measured and computed amplitudes.
std::pair<std::vector<double>, std::vector<double>> to_amplitudes(Samples& measured, Samples& model) {
  auto a = mean_of(measured), b = mean_of(model);
  for (auto* list : {&a, &b})
    for (auto& x : *list) x = std::sqrt(x);
  for (auto* list : {&measured, &model})
    for (auto& one : *list)
      for (std::size_t i = 0; i < a.size(); ++i) one[i] = a[i] + b[i] > 0 ? one[i] / (a[i] + b[i]) : 0;
  return {a, b};
}

/// "250°", or "scattered" if the angles have no common direction.
std::string direction(const Samples& angles) {
  const auto mean = mean_of(angles);
  return std::hypot(mean[0], mean[1]) < 0.5
             ? "scattered"
             : fmt::format("{:.4g}°", whole_circle(std::atan2(mean[1], mean[0]) * to_degrees));
}

std::string spectrum_text(const std::vector<double>& measured, const std::vector<double>& model,
                          const MeanDifference& d) {
  std::size_t most = 0;
  const auto apart = [&](std::size_t i) { return std::abs(measured[i] - model[i]); };
  for (std::size_t i = 1; i < measured.size(); ++i)
    if (apart(i) > apart(most)) most = i;
  return fmt::format(
      "the spectra differ by {:.3g} m/s² ({:.3g} is explained), most in harmonics {} to {}: the model has "
      "{:.3g} times the measured amplitude",
      d.size, d.limit, 1u << most, (2u << most) - 1, model[most] / measured[most]);
}

void find_differences(const Features& measured, const Features& model, bool datum, Agreement& a,
                      const std::string& spectra) {
  const auto& p = a.properties;
  const auto outside = [](const Interval& x, double expected, double least) {
    return (x.low > expected || x.high < expected) && std::abs(x.mean - expected) > least;
  };
  if (a.sign < 0 && a.sign_decided)
    a.findings.emplace_back("the sign of the measured curve is opposite to the model's");
  const auto& mean = p[Agreement::offset];
  const auto offset =
      fmt::format("the measured signal has a constant offset of {:.3g} m/s² from the model's{}", a.shift,
                  std::isfinite(mean.difference.expected)
                      ? fmt::format(" (standard error {:.2g})", mean.difference.expected)
                      : "");
  if (mean.differs())
    a.findings.push_back(offset);
  else if (a.small_offset())
    a.remarks.push_back(fmt::format("{}, beyond its uncertainty; below {:g} % of the signal it is not judged",
                                    offset, 100 * least_amplitude));
  else if (mean.difference.size > mean.least)
    a.remarks.push_back(offset + ", within the uncertainty");
  a.faulty_signal = !a.findings.empty();
  if (const auto& d = p[Agreement::waveform]; d.differs()) {
    // Gain and phase explain a difference of the waveform.
    if (outside(a.gain, 1, least_amplitude))
      a.findings.push_back(fmt::format("the measured curve is {:.4g} ({:.4g}..{:.4g}) times the model's",
                                       a.gain.mean, a.gain.low, a.gain.high));
    if (datum && outside(a.phase, 0, least_angle))
      a.findings.push_back(
          fmt::format("the model lags the measurement by {:.4g}° ({:.4g}..{:.4g}) of crank angle",
                      a.phase.mean, a.phase.low, a.phase.high));
    a.findings.push_back(fmt::format("the mean revolutions differ by {:.3g} m/s² ({:.3g} is explained)",
                                     d.difference.size, d.difference.limit));
  }
  if (const auto& d = p[Agreement::peaks]; d.differs())
    a.findings.push_back(fmt::format(
        "the model's peaks are {:.3g} times the measured ones (a factor of {:.3g} is explained)",
        std::exp(mean_of(model.of[Agreement::peaks])[0] - mean_of(measured.of[Agreement::peaks])[0]),
        std::exp(d.difference.limit)));
  if (p[Agreement::peak_angles].differs())
    a.findings.push_back(fmt::format(
        "the crank angles of the peaks differ: {} in the model, {} in the measurement",
        direction(model.of[Agreement::peak_angles]), direction(measured.of[Agreement::peak_angles])));
  if (p[Agreement::spectrum].differs()) a.findings.push_back(spectra);
}

}  // namespace

Quiet quiet_stretch(const std::vector<double>& mean_turn, double ideal_maximum) {
  const int n = static_cast<int>(mean_turn.size());
  int best = 0, from = 0, run = 0;
  for (int i = 0; i < 2 * n; ++i) {  // two revolutions, since an interval may wrap
    run = std::abs(mean_turn[i % n]) <= 0.05 * ideal_maximum ? run + 1 : 0;
    if (run > best && run <= n) {
      best = run;
      from = i - run + 1;
    }
  }
  if (best == 0) return {std::nan(""), std::nan("")};
  return {whole_circle(from * 360.0 / n), whole_circle((from + best) * 360.0 / n)};
}

const char* text_of(Agreement::Verdict verdict) {
  constexpr const char* names[] = {"agrees", "differs", "undecided", "stopped"};
  return names[static_cast<int>(verdict)];
}

void assess(const TurnMetrics& measured, double uncertainty, bool datum, Agreement& a) {
  const auto al = align(measured.turns, a.metrics.turns);
  const auto M = mean_of(measured.turns);
  double power = 0;
  for (std::size_t k = 1; k < M.size(); ++k) power += 2 * std::norm(M[k]);
  a.rms_measured = std::sqrt(power);
  const double relative = uncertainty / a.rms_measured;
  // A single turn has no scatter; without an uncertainty of the file nothing is known.
  const auto combined = [](double scatter, double given) {
    return given > 0 ? std::hypot(std::isnan(scatter) ? 0 : scatter, given) : scatter;
  };
  const auto about = [](double mean, double error) {
    return Interval{1, mean, mean - 1.96 * error, mean + 1.96 * error, mean, mean};
  };
  a.sign = al.sign;
  a.sign_decided = al.decided;
  a.gain = about(al.gain, combined(al.gain_error, al.gain * relative));
  a.phase = about(al.phase * to_degrees, combined(al.phase_error, relative / al.slope) * to_degrees);
  a.moved = datum ? 0 : a.phase.mean;
  a.mean_turn = bin_means(moved(mean_of(a.metrics.turns), a.moved / to_degrees), mean_bins);

  auto count = M.size();
  for (const std::vector<Harmonics>* list : {&measured.turns, &std::as_const(a.metrics.turns)})
    for (const auto& turn : *list) count = std::min(count, turn.size());
  auto of_measured = features(measured.turns, count, 0, uncertainty),
       of_model = features(a.metrics.turns, count, a.moved / to_degrees, uncertainty);
  const auto [B, A] = to_amplitudes(of_measured.of[Agreement::spectrum], of_model.of[Agreement::spectrum]);
  const double least = least_amplitude * a.rms_measured;
  const std::array<double, Agreement::count> common{uncertainty, uncertainty, uncertainty / of_measured.peak,
                                                    0.5 * of_model.spread, uncertainty},
      leasts{least, least, std::log1p(least_amplitude), least_angle / to_degrees, least};
  for (std::size_t i = 0; i < Agreement::count; ++i)
    a.properties[i] = {difference_of_means(of_measured.of[i], of_model.of[i], common[i], property_error),
                       leasts[i]};
  // The scatter of a single measured revolution is unknown.
  if (measured.turns.size() < 2 && uncertainty == 0)
    for (auto& p : a.properties) p.difference.expected = p.difference.limit = NAN;
  a.shift = mean_of(of_measured.of[Agreement::offset])[0] - mean_of(of_model.of[Agreement::offset])[0];

  double apart = 0, size = 0;
  for (std::size_t h = 0; h < std::min(a.metrics.spectrum.size(), measured.spectrum.size()); ++h) {
    apart += std::pow(a.metrics.spectrum[h] - measured.spectrum[h], 2);
    size += measured.spectrum[h] * measured.spectrum[h];
  }
  a.spectral_distance = std::sqrt(apart / size);
  const auto ratio = [&](TurnMetrics::Name m) { return a.metrics.value[m] / measured.value[m]; };
  a.peak_ratio = ratio(TurnMetrics::peak_median);
  a.greatest_ratio = ratio(TurnMetrics::peak_max);
  a.loss_angle = whole_circle(a.metrics.value[TurnMetrics::loss_angle] + a.moved);
  a.return_angle = whole_circle(a.metrics.value[TurnMetrics::return_angle] + a.moved);

  find_differences(of_measured, of_model, datum, a,
                   spectrum_text(B, A, a.properties[Agreement::spectrum].difference));
  const double limit = a.properties[Agreement::waveform].difference.limit;
  a.verdict = !a.findings.empty()      ? Agreement::Verdict::differs
              : limit < a.rms_measured ? Agreement::Verdict::agrees  // false for NaN
                                       : Agreement::Verdict::undecided;
}

SignalOffset offset_from(double mean, const TurnMetrics& measured, double uncertainty) {
  Samples means;
  for (const auto& turn : measured.turns) means.push_back({turn[0].real()});
  // Two equal members: a mean without scatter.
  const auto d = difference_of_means(means, {{mean}, {mean}}, uncertainty, property_error);
  const bool known = means.size() > 1 || uncertainty > 0;
  const double rounding = offset_rounding * measured.value[TurnMetrics::rms];
  return {mean_of(means)[0] - mean, known ? d.expected : NAN, known ? std::max(d.limit, rounding) : NAN};
}

double unsteadiness(const TurnMetrics& turns, double uncertainty) {
  const auto n = turns.turns.size();
  if (n < 4) return 0;
  auto count = turns.turns.front().size();
  for (const auto& turn : turns.turns) count = std::min(count, turn.size());
  const auto wave = features(turns.turns, count, 0, 0).of[Agreement::waveform];
  const Samples first(wave.begin(), wave.begin() + static_cast<long>(n / 2)),
      second(wave.begin() + static_cast<long>(n / 2), wave.end());
  const auto d = difference_of_means(first, second, uncertainty, property_error);
  return d.size > std::max(d.limit, least_amplitude * turns.value[TurnMetrics::mean_turn_rms]) ? d.size : 0;
}

namespace {

double median(std::vector<double> list) {
  std::ranges::sort(list);
  return quantile(list, 0.5);
}

/// The distance of each turn from the median turn (m/s²).
std::vector<double> distances(const std::vector<Harmonics>& turns) {
  auto count = turns.front().size();
  for (const auto& turn : turns) count = std::min(count, turn.size());
  std::vector<double> squares(turns.size()), real(turns.size()), imaginary(turns.size());
  for (std::size_t h = 0; h < count; ++h) {
    for (std::size_t i = 0; i < turns.size(); ++i)
      real[i] = turns[i][h].real(), imaginary[i] = turns[i][h].imag();
    const std::complex<double> middle(median(real), median(imaginary));
    for (std::size_t i = 0; i < turns.size(); ++i)
      squares[i] += (h == 0 ? 1 : 2) * std::norm(turns[i][h] - middle);
  }
  for (auto& x : squares) x = std::sqrt(x);
  return squares;
}

/// The least distance of an outlying turn beside others.
double outlying(const std::vector<double>& others) {
  return std::max(outlying_median * median(others), outlying_greatest * *std::ranges::max_element(others));
}

}  // namespace

OutlyingTurns outlying_turns(const TurnMetrics& measured) {
  const auto n = measured.turns.size();
  OutlyingTurns found;
  if (n < 8) return found;
  const auto d = distances(measured.turns);
  const auto from = [&](std::size_t first) {
    return std::vector<double>(d.begin() + static_cast<long>(first), d.end());
  };
  const auto later = from(n / 4);
  found.ratio = INFINITY;
  for (; found.start < n / 4 && d[found.start] > outlying(later); ++found.start)
    found.ratio = std::min(found.ratio, d[found.start] / median(later));
  auto others = from(found.start);
  const auto worst = std::ranges::max_element(others);
  const double greatest = *worst;
  const auto index = static_cast<std::size_t>(worst - others.begin()) + found.start;
  others.erase(worst);
  if (greatest > outlying(others))
    found.single = static_cast<int>(index), found.single_ratio = greatest / median(others);
  return found;
}

double measured_statistic(const Study& study, Target& target, const Conduct& conduct,
                          std::vector<std::string>& plausibility_checks) {
  Case one{"", study.calibration->formulation, {}, 0, 1, study.scene, target.overrides};
  const auto scene = scene_of(study, one, conduct);
  const double speed = main_drive(scene.mechanism)->speed;
  const auto ideal = ideal_metrics(study, scene, study.calibration->formulation, conduct);
  const auto data =
      read_measurement(target.data, speed, ideal.value[TurnMetrics::peak_max], study.accelerometer);
  target.sampling = data.sampling;
  target.noise = data.uncertainty;
  TurnRules rules;
  rules.speed = speed;
  rules.joint = -1;
  rules.thresholds.line_share = study.thresholds.line_share;
  rules.ideal_maximum = ideal.value[TurnMetrics::peak_max];
  const auto between = [&](double from, double to) {
    TurnMeter meter(rules);
    for (std::size_t i = 0; i < data.acceleration.size(); ++i)
      if (data.time[i] >= from && data.time[i] < to) meter.acceleration(data.time[i], data.acceleration[i]);
    return meter.finish(data.time.back(), std::nan(""));
  };
  const auto measured = between(-INFINITY, INFINITY);
  if (const auto plausibility = unit_plausibility(measured, ideal); !plausibility.empty())
    plausibility_checks.push_back(fmt::format("{}: {}", target.data.string(), plausibility));
  // Evaluate segments as long as a run: their mean has the expectation of the runs, even for a
  // statistic that depends on the number of turns.
  const auto whole = static_cast<int>(measured.peaks.size());
  target.turns = std::clamp(static_cast<int>(study.calibration->revolutions), 1, std::max(whole, 1));
  if (target.is_waveform()) {
    const auto expected = expected_difference(turns_of(data, speed), target.turns, target.tolerance);
    if (!(expected.value > 0))
      throw SceneError(fmt::format("{}: a waveform needs at least two revolutions", target.data.string()));
    target.tolerance = expected.deviation;
    target.stretches.known = true;
    return expected.value;
  }
  target.stretches.count = std::max(1, whole / target.turns);
  const double stretch = target.turns * 2 * std::numbers::pi / std::abs(speed);
  // With rounded times, a sample at the end of a segment belongs to the next one.
  const double half = 0.5 / data.sampling;
  double value = 0, squares = 0;
  std::vector<double> of;
  for (int k = 0; k < target.stretches.count; ++k) {
    const double from = data.time.front() + k * stretch - half;
    of.push_back(between(from, target.stretches.count > 1 ? from + stretch : INFINITY)
                     .value[statistic_of(study, target).metric]);
    value += of.back() / target.stretches.count;
  }
  if (!(value > 0))
    throw SceneError(fmt::format("{}: has no {} (a signal has no contacts, and a logarithm is fitted)",
                                 target.data.string(), target.statistic));
  for (const double x : of) squares += std::pow(x / value - 1, 2);
  if (of.size() > 1) target.stretches.spread = squares / static_cast<double>(of.size() - 1);
  return value;
}

}  // namespace freeplay
