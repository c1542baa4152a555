#include "study/validate.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "model/contacts.hpp"
#include "model/scene.hpp"
#include "study/data_units.hpp"
#include "values/family.hpp"

namespace freeplay {
namespace {

double degrees(double x) {
  const double d = std::fmod(x, 360);
  return d < 0 ? d + 360 : d;
}

/// The circular shift of `model`, in bins, that correlates best with `measured`.
int best_shift(const std::vector<double>& measured, const std::vector<double>& model) {
  const int n = static_cast<int>(measured.size());
  int best = 0;
  double greatest = -INFINITY;
  for (int s = 0; s < n; ++s) {
    double sum = 0;
    for (int i = 0; i < n; ++i) sum += measured[i] * model[(i - s + n) % n];
    if (sum > greatest) {
      greatest = sum;
      best = s;
    }
  }
  return best;
}

/// What `validate` asks of a scene, in the words of a study.
Study study_of(const Scene& scene) {
  Study study;
  study.file = study.scene = scene.file;
  const auto fail = [&](const char* what) {
    throw SceneError(fmt::format("{}: {}", scene.file.string(), what));
  };
  for (const auto& i : scene.instruments)
    if (i.kind == Instrument::Kind::accelerometer && study.accelerometer.empty())
      study.accelerometer = i.name;
  if (study.accelerometer.empty()) fail("has no accelerometer to compare with the file");
  const auto* drive = main_drive(scene.mechanism);
  if (!drive || drive->speed == 0) fail("has no drive of prescribed speed, to count turns by");
  const auto contacts = contact_names(scene.mechanism);
  if (contacts.empty()) fail("has no joint with clearance");
  study.joint = contacts.front();
  const double turn = 2 * std::numbers::pi / std::abs(drive->speed);
  study.discard = scene.run.discard / turn;
  study.revolutions = (scene.run.duration - scene.run.discard) / turn;
  if (study.revolutions < 1) fail("must run at least a turn after its discard");
  return study;
}

}  // namespace

Quiet quiet_stretch(const std::vector<double>& mean_turn, double ideal_maximum) {
  const int n = static_cast<int>(mean_turn.size());
  int best = 0, from = 0, run = 0;
  for (int i = 0; i < 2 * n; ++i) {  // twice around: a stretch may wrap
    run = std::abs(mean_turn[i % n]) <= 0.05 * ideal_maximum ? run + 1 : 0;
    if (run > best && run <= n) {
      best = run;
      from = i - run + 1;
    }
  }
  if (best == 0) return {std::nan(""), std::nan("")};
  return {degrees(from * 360.0 / n), degrees((from + best) * 360.0 / n)};
}

Validation validate(const std::filesystem::path& file, const std::vector<std::string>& overrides,
                    const std::filesystem::path& data, const Conduct& conduct) {
  const auto scene = read_scene(file, overrides);
  const auto study = study_of(scene);
  const auto* drive = main_drive(scene.mechanism);
  Validation v;
  const auto ideal = ideal_turn(study, scene, "penalty", conduct);
  v.ideal_maximum = ideal.value[TurnMetrics::peak_max];
  const auto measured = read_measurement(data, drive->speed, v.ideal_maximum);
  v.sampling = measured.sampling;
  v.uncertainty = measured.uncertainty;
  TurnRules rules;
  rules.speed = drive->speed;
  rules.crank_start = measured.start_angle * std::numbers::pi / 180;
  rules.sampling = measured.sampling;
  rules.ideal_maximum = v.ideal_maximum;
  TurnMeter meter(rules);
  for (std::size_t i = 0; i < measured.acceleration.size(); ++i)
    meter.acceleration(static_cast<double>(i) / measured.sampling, measured.acceleration[i]);
  v.measured = meter.finish(std::nan(""));
  v.question = unit_question(v.measured, ideal);
  v.quiet = quiet_stretch(v.measured.mean_turn, v.ideal_maximum);

  for (const auto& formulation : family_names()) {
    const Case one{"", formulation, {}, 0, study.revolutions, file, overrides};
    auto run = run_case(study, one, conduct);
    Agreement a;
    a.formulation = formulation;
    a.ending = run.ending;
    a.metrics = std::move(run.metrics);
    if (a.ending.status == Ending::Status::finished) {
      const int shift = best_shift(v.measured.mean_turn, a.metrics.mean_turn);
      a.phase = shift * 360.0 / mean_bins;
      if (a.phase > 180) a.phase -= 360;
      double squares = 0;
      for (int i = 0; i < mean_bins; ++i) {
        a.mean_turn.push_back(a.metrics.mean_turn[(i - shift + mean_bins) % mean_bins]);
        squares += std::pow(a.mean_turn.back() - v.measured.mean_turn[i], 2);
      }
      a.rms_difference = std::sqrt(squares / mean_bins);
      const auto& A = a.metrics.spectrum;
      const auto& B = v.measured.spectrum;
      double apart = 0, size = 0;
      for (std::size_t h = 0; h < std::min(A.size(), B.size()); ++h) {
        apart += (A[h] - B[h]) * (A[h] - B[h]);
        size += B[h] * B[h];
      }
      a.spectral_distance = std::sqrt(apart / size);
      const auto ratio = [&](TurnMetrics::Name m) { return a.metrics.value[m] / v.measured.value[m]; };
      a.peak_ratio = ratio(TurnMetrics::peak_median);
      a.greatest_ratio = ratio(TurnMetrics::peak_max);
      a.loss_angle = degrees(a.metrics.value[TurnMetrics::loss_angle] + a.phase);
      a.return_angle = degrees(a.metrics.value[TurnMetrics::return_angle] + a.phase);
      a.quiet = quiet_stretch(a.mean_turn, v.ideal_maximum);
    }
    v.models.push_back(std::move(a));
  }
  return v;
}

nlohmann::json to_json(const Validation& v) {
  nlohmann::json models = nlohmann::json::object();
  for (const auto& a : v.models)
    models[a.formulation] = {{"ending", a.ending.reason},
                             {"phase_deg", a.phase},
                             {"peak_ratio_median", a.peak_ratio},
                             {"peak_ratio_greatest", a.greatest_ratio},
                             {"rms_difference_m_per_s2", a.rms_difference},
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
          {"models", models}};
}

}  // namespace freeplay
