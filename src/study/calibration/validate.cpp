#include "study/calibration/validate.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <stdexcept>

#include "dynamics/contacts.hpp"
#include "measure/alignment.hpp"
#include "mechanism/scene.hpp"
#include "study/calibration/data_units.hpp"
#include "study/runs/ideal_turn.hpp"
#include "study/runs/long_run.hpp"
#include "values/family.hpp"

namespace freeplay {
namespace {

/// The scene as a study, for evaluating its metrics.
Study study_of(const Scene& scene) {
  Study study;
  study.file = study.scene = scene.file;
  const auto fail = [&](const char* what) {
    throw SceneError(fmt::format("{}: {}", scene.file.string(), what));
  };
  for (const auto& i : scene.instruments)
    if (i.kind == Instrument::Kind::accelerometer && study.accelerometer.empty())
      study.accelerometer = i.name;
  if (study.accelerometer.empty()) fail("has no accelerometer for the comparison with the file");
  const auto* drive = main_drive(scene.mechanism);
  if (!drive || drive->speed == 0)
    fail(
        "has no drive of prescribed speed, which is needed to count "
        "revolutions");
  const auto contacts = contact_names(scene.mechanism);
  if (contacts.empty()) fail("has no joint with clearance");
  study.joints = {contacts.front()};
  const double turn = 2 * std::numbers::pi / std::abs(drive->speed);
  study.discard = scene.run.discard / turn;
  study.revolutions = (scene.run.duration - scene.run.discard) / turn;
  if (study.revolutions < 1) fail("must run at least one revolution after the discarded time");
  return study;
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
  switch (verdict) {
    case Agreement::Verdict::agrees:
      return "agrees";
    case Agreement::Verdict::differs:
      return "differs";
    case Agreement::Verdict::undecided:
      return "undecided";
  }
  throw std::logic_error("no such verdict");
}

void assess(const TurnMetrics& measured, double uncertainty, bool datum, Agreement& a) {
  const auto al = align(measured.turns, a.metrics.turns);
  const auto M = mean_of(measured.turns);
  double power = 0;
  for (std::size_t k = 1; k < M.size(); ++k) power += 2 * std::norm(M[k]);
  const double relative = uncertainty / std::sqrt(power);
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
  const double to_degrees = 180 / std::numbers::pi;
  a.phase = about(al.phase * to_degrees, combined(al.phase_error, relative / al.slope) * to_degrees);
  a.moved = datum ? 0 : a.phase.mean;
  a.mean_turn = bin_means(moved(mean_of(a.metrics.turns), a.moved / to_degrees), mean_bins);
  double squares = 0, own = 0;
  for (int i = 0; i < mean_bins; ++i) {
    squares += std::pow(a.mean_turn[i] - measured.mean_turn[i], 2);
    own += std::pow(measured.mean_turn[i], 2);
  }
  a.rms_difference = std::sqrt(squares / mean_bins);
  a.rms_measured = std::sqrt(own / mean_bins);
  a.rms_expected = combined(al.difference_error, uncertainty);
  const auto& A = a.metrics.spectrum;
  const auto& B = measured.spectrum;
  double apart = 0, size = 0;
  for (std::size_t h = 0; h < std::min(A.size(), B.size()); ++h) {
    apart += (A[h] - B[h]) * (A[h] - B[h]);
    size += B[h] * B[h];
  }
  a.spectral_distance = std::sqrt(apart / size);
  const auto ratio = [&](TurnMetrics::Name m) { return a.metrics.value[m] / measured.value[m]; };
  a.peak_ratio = ratio(TurnMetrics::peak_median);
  // The standard error of a median is √(π/2) σ/√n for normal deviates.
  const auto of_median = [](const TurnMetrics& m) {
    if (m.peaks.size() < 2) return 0.0;
    const auto [mean, variance] = moments(m.peaks);
    return std::sqrt(std::numbers::pi / 2 * variance / static_cast<double>(m.peaks.size())) / mean;
  };
  a.peak_error = a.peak_ratio * std::hypot(of_median(measured), of_median(a.metrics),
                                           uncertainty / measured.value[TurnMetrics::peak_median]);
  a.greatest_ratio = ratio(TurnMetrics::peak_max);
  a.loss_angle = whole_circle(a.metrics.value[TurnMetrics::loss_angle] + a.moved);
  a.return_angle = whole_circle(a.metrics.value[TurnMetrics::return_angle] + a.moved);

  const auto beyond = [](const Interval& x, double expected, double tolerated) {
    return (x.low > expected || x.high < expected) && std::abs(x.mean - expected) > tolerated;
  };
  if (a.sign < 0 && a.sign_decided)
    a.findings.emplace_back("the sign of the measured curve is opposite to the model's");
  if (beyond(a.gain, 1, told_gain))
    a.findings.push_back(fmt::format("the measured curve is {:.4g} ({:.4g}..{:.4g}) times the model's",
                                     a.gain.mean, a.gain.low, a.gain.high));
  if (datum && beyond(a.phase, 0, told_phase))
    a.findings.push_back(
        fmt::format("the model lags the measurement by {:.4g}° ({:.4g}..{:.4g}) of crank angle", a.phase.mean,
                    a.phase.low, a.phase.high));
  if (a.rms_difference > told_difference * a.rms_expected)
    a.findings.push_back(
        fmt::format("the mean revolutions differ by {:.4g} m/s², {:.3g} times the uncertainty and scatter",
                    a.rms_difference, a.rms_difference / a.rms_expected));
  const bool decides = told_difference * a.rms_expected < a.rms_measured;  // false for NaN
  a.verdict = !a.findings.empty() ? Agreement::Verdict::differs
              : decides           ? Agreement::Verdict::agrees
                                  : Agreement::Verdict::undecided;
}

SignalAgreement::Outcome outcome_of(Agreement::Verdict verdict) {
  using enum SignalAgreement::Outcome;
  return verdict == Agreement::Verdict::agrees    ? agrees
         : verdict == Agreement::Verdict::differs ? differs
                                                  : undecided;
}

Validation validate(const std::filesystem::path& file, const std::vector<std::string>& overrides,
                    const std::filesystem::path& data, const Conduct& conduct) {
  const auto scene = read_scene(file, overrides);
  const auto study = study_of(scene);
  const auto* drive = main_drive(scene.mechanism);
  Validation v;
  const auto ideal = ideal_turn(study, scene, "penalty", conduct);
  v.ideal_maximum = ideal.value[TurnMetrics::peak_max];
  const auto measured = read_measurement(data, drive->speed, v.ideal_maximum, study.accelerometer);
  v.sampling = measured.sampling;
  v.uncertainty = measured.uncertainty;
  TurnRules rules;
  rules.speed = drive->speed;
  rules.crank_start = measured.start_angle * std::numbers::pi / 180;
  rules.joint = -1;
  rules.ideal_maximum = v.ideal_maximum;
  TurnMeter meter(rules);
  for (std::size_t i = 0; i < measured.acceleration.size(); ++i)
    meter.acceleration(measured.time[i], measured.acceleration[i]);
  v.measured = meter.finish(measured.time.back(), std::nan(""));
  v.plausibility = unit_plausibility(v.measured, ideal);
  v.quiet = quiet_stretch(v.measured.mean_turn, v.ideal_maximum);

  for (const auto& formulation : family_names()) {
    const Case one{"", formulation, {}, 0, study.revolutions, file, overrides, measured.sampling};
    auto run = run_case(study, one, conduct);
    Agreement a;
    a.formulation = formulation;
    a.ending = run.ending;
    a.metrics = std::move(run.metrics);
    if (a.ending.status == Ending::Status::finished && a.metrics.turns.empty())
      a.ending = {Ending::Status::failed, "no complete revolution was sampled after the discarded time"};
    if (a.ending.status == Ending::Status::finished) {
      assess(v.measured, v.uncertainty, measured.datum, a);
      a.quiet = quiet_stretch(a.mean_turn, v.ideal_maximum);
    }
    v.models.push_back(std::move(a));
  }
  std::vector<SignalAgreement> models;
  for (const auto& a : v.models) {
    const bool finished = a.ending.status == Ending::Status::finished;
    models.push_back({a.formulation, finished ? outcome_of(a.verdict) : SignalAgreement::Outcome::stopped,
                      a.findings.empty() ? "" : a.findings.front(), a.rms_difference, a.rms_expected,
                      finished ? a.peak_ratio : NAN, a.peak_error, a.rms_measured,
                      finished ? a.greatest_ratio : NAN});
  }
  v.conclusion = verdict(models);
  return v;
}

nlohmann::json to_json(const Validation& v) {
  nlohmann::json models = nlohmann::json::object();
  const auto of = [](const Interval& x) {
    return nlohmann::json{{"value", x.mean}, {"low", x.low}, {"high", x.high}};
  };
  for (const auto& a : v.models)
    models[a.formulation] = {{"ending", a.ending.reason},
                             {"verdict", text_of(a.verdict)},
                             {"findings", a.findings},
                             {"sign", a.sign},
                             {"sign_beyond_doubt", a.sign_decided},
                             {"gain", of(a.gain)},
                             {"phase_deg", of(a.phase)},
                             {"moved_by_deg", a.moved},
                             {"peak_ratio_median", a.peak_ratio},
                             {"peak_ratio_greatest", a.greatest_ratio},
                             {"rms_difference_m_per_s2", a.rms_difference},
                             {"rms_expected_m_per_s2", a.rms_expected},
                             {"spectral_distance", a.spectral_distance},
                             {"contact_lost_deg", a.loss_angle},
                             {"contact_found_deg", a.return_angle},
                             {"quiet_from_deg", a.quiet.from},
                             {"quiet_to_deg", a.quiet.to}};
  return {{"ideal_greatest_m_per_s2", v.ideal_maximum},
          {"measured",
           {{"sampling_Hz", v.sampling},
            {"turns", v.measured.peaks.size()},
            {"uncertainty_m_per_s2", v.uncertainty},
            {"peak_median_m_per_s2", v.measured.value[TurnMetrics::peak_median]},
            {"peak_greatest_m_per_s2", v.measured.value[TurnMetrics::peak_max]},
            {"quiet_from_deg", v.quiet.from},
            {"quiet_to_deg", v.quiet.to}}},
          {"models", models},
          {"verdict", v.conclusion}};
}

}  // namespace freeplay
