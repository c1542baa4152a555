#include "study/calibration/validate.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <iterator>
#include <numbers>
#include <optional>

#include "dynamics/evaluation.hpp"
#include "io/scene/write_scene.hpp"
#include "mechanism/scene.hpp"
#include "study/comparison/settings.hpp"
#include "study/runs/executor.hpp"
#include "study/runs/turns.hpp"
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
  study.length.discard = scene.run.discard / turn;
  study.length.revolutions = (scene.run.duration - scene.run.discard) / turn;
  if (study.length.revolutions < 1) fail("must run at least one revolution after the discarded time");
  return study;
}

/// The keys of the scene's clearances and backlashes, with their values.
std::vector<std::pair<std::string, double>> clearances(const Scene& scene) {
  std::vector<std::pair<std::string, double>> found;
  for (const auto& line : canonical_lines(to_toml(scene)))
    if (line.key.ends_with(".clearance") || line.key.ends_with(".backlash"))
      if (const double value = std::strtod(line.value.c_str(), nullptr); value > 0)
        found.emplace_back(line.key, value);
  return found;
}

/// Runs the model and compares it. Motions of one model may settle on different attractors, so that it
/// differs only if the runs from all starts do; then the one with the smallest difference of the waveform is
/// returned. Throws SceneError.
Agreement compared(const Study& study, Case one, const Validation& v, bool datum, const Conduct& conduct) {
  std::optional<Agreement> nearest;
  const auto apart = [](const Agreement& a) { return a.properties[Agreement::waveform].difference.size; };
  const int starts = has_starts(study, one) ? model_starts : 1;
  for (one.start = 0; one.start < starts; ++one.start) {
    auto run = run_case(study, one, conduct);
    Agreement a;
    a.formulation = one.formulation;
    a.ending = run.ending;
    a.metrics = std::move(run.metrics);
    if (a.ending.status == Ending::Status::finished && a.metrics.turns.empty())
      a.ending = {Ending::Status::failed, "no complete revolution was sampled after the discarded time"};
    if (a.ending.status != Ending::Status::finished) return a;
    assess(v.measured, v.uncertainty, datum, a);
    a.starts = one.start + 1;
    if (a.verdict != Agreement::Verdict::differs || a.faulty_signal) return a;
    if (!nearest || apart(a) < apart(*nearest)) nearest = std::move(a);
    nearest->starts = one.start + 1;
  }
  return *nearest;
}

/// Adds the remarks on outlying revolutions of the measured signal.
void note_outliers(const OutlyingTurns& found, std::vector<std::string>& remarks) {
  constexpr double shown = 1000;  // of exactly repeated revolutions the distance is rounding
  if (found.start > 0)
    remarks.push_back(fmt::format(
        "left out at the start of the measured signal: {}, at least {:.0f} times as far from the median "
        "revolution as half of the others; they would raise the scatter by which differences are explained",
        found.start == 1 ? "1 revolution" : fmt::format("{} revolutions", found.start),
        std::floor(std::min(found.ratio, shown))));
  if (found.single >= 0)
    remarks.push_back(fmt::format(
        "revolution {} of the measured signal is at least {:.0f} times as far from the median revolution as "
        "half of the others and raises the scatter by which differences are explained; correct it",
        found.single + 1, std::floor(std::min(found.single_ratio, shown))));
}

/// "1.2 times (0.3 mm)"
std::string clearance_text(const ClearanceTrial& t) {
  return fmt::format("{:g} times ({:.3g} mm)", t.factor, 1e3 * t.factor * t.clearance);
}

}  // namespace

void assess_power(const std::vector<ClearanceTrial>& trials, Agreement& a) {
  bool passes = false;
  a.power.clear();
  for (auto first = trials.begin(); first != trials.end();) {
    const auto last = std::find_if(first, trials.end(), [&](const auto& t) { return t.key != first->key; });
    // The nearest factor on each side from which on outwards all trials are found.
    const ClearanceTrial *above = nullptr, *below = nullptr;
    for (auto t = last; t != first && (t - 1)->factor > 1 && (t - 1)->found; --t) above = &*(t - 1);
    for (auto t = first; t != last && t->factor < 1 && t->found; ++t) below = &*t;
    const auto& key = first->key;
    passes = passes || (above && below);
    a.power += a.power.empty() ? "" : "; ";
    if (above && below)
      a.power += fmt::format("the same test finds {} from {} and up to {} of its value", key,
                             clearance_text(*above), clearance_text(*below));
    else if (above || below)
      a.power += fmt::format("the same test finds {} {} {}, but no {} one", key, above ? "from" : "up to",
                             clearance_text(above ? *above : *below), above ? "smaller" : "greater");
    else
      a.power += fmt::format("the same test also accepts half or twice {}", key);
    first = last;
  }
  if (trials.empty()) a.power = "the scene has no clearance with which to measure the power of the test";
  if (!passes && a.verdict == Agreement::Verdict::agrees) a.verdict = Agreement::Verdict::undecided;
}

Validation validate(const std::filesystem::path& file, const std::vector<std::string>& overrides,
                    const std::filesystem::path& data, const ValidateSetup& setup, const Conduct& conduct) {
  const auto scene = read_scene(file, overrides);
  auto study = study_of(scene);
  const auto* drive = main_drive(scene.mechanism);
  Validation v;
  const auto ideal = ideal_metrics(study, scene, "penalty", conduct);
  v.ideal_maximum = ideal.value[TurnMetrics::peak_max];
  const auto measured = read_measurement(data, drive->speed, v.ideal_maximum, study.accelerometer);
  v.sampling = measured.sampling;
  v.uncertainty = measured.uncertainty;
  TurnRules rules;
  rules.speed = drive->speed;
  rules.crank_start = measured.start_angle * std::numbers::pi / 180;
  rules.joint = -1;
  rules.ideal_maximum = v.ideal_maximum;
  const auto metered = [&](double offset) {
    TurnMeter meter(rules);
    const double begin = static_cast<double>(v.left_out) * 2 * std::numbers::pi / std::abs(drive->speed);
    for (std::size_t i = 0; i < measured.acceleration.size(); ++i)
      if (measured.time[i] >= begin - 1e-6 / measured.sampling)
        meter.acceleration(measured.time[i], measured.acceleration[i] - offset);
    return meter.finish(measured.time.back(), std::nan(""));
  };
  v.measured = metered(0);
  const auto outliers = outlying_turns(v.measured);
  if (outliers.start > 0) {
    v.left_out = outliers.start;
    v.measured = metered(0);
  }
  note_outliers(outliers, v.remarks);
  if (!ideal.turns.empty()) v.offset = offset_from(ideal.turns.front()[0].real(), v.measured, v.uncertainty);
  if (setup.remove_offset) {
    if (ideal.turns.empty())
      throw SceneError(
          fmt::format("{}: --remove-offset needs a whole revolution of the ideal mechanism", file.string()));
    v.offset_removed = true;
    v.measured = metered(v.offset.value);
    v.remarks.push_back(
        fmt::format("a constant offset of {:.3g} m/s² was removed from the measured signal; it is fitted to "
                    "the mean of the ideal mechanism, so agreement of the mean is no evidence",
                    v.offset.value));
  }
  v.plausibility = unit_plausibility(v.measured, ideal);
  v.quiet = quiet_stretch(v.measured.mean_turn, v.ideal_maximum);
  v.stated = study.length.revolutions;
  if (study.length.discard == 0) study.length.discard = 2;
  study.length.revolutions =
      setup.revolutions > 0 ? setup.revolutions
                            : std::max(study.length.revolutions,
                                       std::clamp(static_cast<double>(v.measured.peaks.size()), 20.0, 200.0));
  v.revolutions = study.length.revolutions;
  v.discarded = study.length.discard;

  const auto run_all_of = [&](const std::vector<Case>& all, bool trial) {
    std::vector<Agreement> results(all.size());
    const auto one = [&](std::size_t i) {
      try {
        results[i] = compared(study, all[i], v, measured.datum, conduct);
      } catch (const SceneError& e) {
        if (!trial) throw;
        results[i].ending = {Ending::Status::failed, e.what()};  // impossible with this clearance
      }
    };
    execute_jobs(0, all.size(), conduct.stop, one, [&](std::size_t done, std::size_t) {
      if (setup.on_progress)
        setup.on_progress(trial ? "other clearances" : "models",
                          static_cast<double>(done) / static_cast<double>(all.size()));
    });
    return results;
  };
  const Case stated{"", "", {}, 0, study.length.revolutions, file, overrides, measured.sampling};
  std::vector<Case> cases;
  for (const auto& formulation : family_names()) {
    cases.push_back(stated);
    cases.back().formulation = formulation;
  }
  v.models = run_all_of(cases, false);
  cases.clear();
  if (const double d = unsteadiness(v.measured, v.uncertainty); d > 0)
    v.remarks.push_back(
        fmt::format("the measured revolutions change with time: the means of the first and "
                    "second half differ by {:.3g} m/s²",
                    d));
  for (auto& a : v.models) {
    if (a.ending.status != Ending::Status::finished) continue;
    a.quiet = quiet_stretch(a.mean_turn, v.ideal_maximum);
    if (const double d = unsteadiness(a.metrics, 0); d > 0) {
      a.remarks.push_back(
          fmt::format("the run is not stationary: the means of the first and second half of its "
                      "revolutions differ by {:.3g} m/s²; raise run.discard or --revolutions",
                      d));
    }
    if (a.verdict != Agreement::Verdict::agrees) continue;
    for (const auto& [key, value] : clearances(scene))
      for (const double factor : trial_factors) {
        auto& one = cases.emplace_back(stated);
        one.formulation = a.formulation;
        one.overrides.push_back(fmt::format("{}={}", key, factor * value));
        v.trials.push_back({key, value, factor, a.formulation});
      }
  }
  const auto trials = run_all_of(cases, true);
  for (std::size_t i = 0; i < trials.size(); ++i) {
    v.trials[i].finished = trials[i].ending.status == Ending::Status::finished;
    v.trials[i].found = v.trials[i].finished && trials[i].verdict == Agreement::Verdict::differs;
  }
  std::vector<SignalAgreement> models;
  for (auto& a : v.models) {
    std::vector<ClearanceTrial> own;
    std::ranges::copy_if(v.trials, std::back_inserter(own),
                         [&](const auto& t) { return t.formulation == a.formulation; });
    if (a.verdict == Agreement::Verdict::agrees) assess_power(own, a);
    const auto& wave = a.properties[Agreement::waveform].difference;
    const bool finished = a.ending.status == Ending::Status::finished;
    models.push_back({a.formulation, finished ? a.verdict : Agreement::Verdict::stopped, a.findings,
                      a.faulty_signal, wave.size, wave.limit, a.rms_measured, a.power,
                      finished && a.small_offset() ? a.shift : 0});
  }
  v.conclusion = verdict(models);
  return v;
}

nlohmann::json to_json(const Validation& v, const std::string& data, bool matched) {
  nlohmann::json models = nlohmann::json::object();
  const auto of = [](const Interval& x) {
    return nlohmann::json{{"value", x.mean}, {"low", x.low}, {"high", x.high}};
  };
  const auto properties = [](const Agreement& a) {
    nlohmann::json list;
    for (std::size_t i = 0; i < Agreement::count; ++i) {
      const auto& p = a.properties[i];
      list[Agreement::names[i]] = {{"difference", p.difference.size},
                                   {"expected", p.difference.expected},
                                   {"limit", p.difference.limit},
                                   {"least", p.least},
                                   {"differs", p.differs()}};
    }
    return list;
  };
  nlohmann::json trials = nlohmann::json::array();
  for (const auto& t : v.trials)
    trials.push_back({{"key", t.key},
                      {"clearance_m", t.factor * t.clearance},
                      {"factor", t.factor},
                      {"formulation", t.formulation},
                      {"finished", t.finished},
                      {"found", t.found}});
  for (const auto& a : v.models)
    models[a.formulation] = {
        {"ending", a.ending.reason},
        {"verdict", text_of(a.verdict)},
        {"starts", a.starts},
        {"findings", a.findings},
        {"sign", a.sign},
        {"sign_beyond_doubt", a.sign_decided},
        {"gain", of(a.gain)},
        {"phase_deg", of(a.phase)},
        {"moved_by_deg", a.moved},
        {"peak_ratio_median", a.peak_ratio},
        {"peak_ratio_greatest", a.greatest_ratio},
        {"rms_measured_m_per_s2", a.rms_measured},
        {"offset_m_per_s2", a.shift},
        {"offset_standard_error_m_per_s2", a.properties[Agreement::offset].difference.expected},
        {"properties", properties(a)},
        {"remarks", a.remarks},
        {"power", a.power},
        {"spectral_distance", a.spectral_distance},
        {"contact_lost_deg", a.loss_angle},
        {"contact_found_deg", a.return_angle},
        {"quiet_from_deg", a.quiet.from},
        {"quiet_to_deg", a.quiet.to}};
  return {{"ideal_greatest_m_per_s2", v.ideal_maximum},
          {"measured",
           {{"sampling_Hz", v.sampling},
            {"turns", v.measured.peaks.size()},
            {"turns_left_out", v.left_out},
            {"uncertainty_m_per_s2", v.uncertainty},
            {"offset",
             {{"value_m_per_s2", v.offset.value},
              {"standard_error_m_per_s2", v.offset.error},
              {"limit_m_per_s2", v.offset.limit},
              {"beyond_uncertainty", v.offset.beyond()},
              {"removed", v.offset_removed}}},
            {"peak_median_m_per_s2", v.measured.value[TurnMetrics::peak_median]},
            {"peak_greatest_m_per_s2", v.measured.value[TurnMetrics::peak_max]},
            {"quiet_from_deg", v.quiet.from},
            {"quiet_to_deg", v.quiet.to}}},
          {"model_revolutions", v.revolutions},
          {"model_discarded_revolutions", v.discarded},
          {"remarks", v.remarks},
          {"models", models},
          {"other_clearances", trials},
          {"verdict", v.conclusion},
          {"data", data},
          {"restitution", matched ? "delivered" : "as-given"}};
}

Table overlay_table(const Validation& v) {
  Table table("crank_angle,measured,penalty,nonsmooth");
  if (std::ranges::all_of(v.models,
                          [](const auto& a) { return a.ending.status == Ending::Status::finished; }))
    for (int i = 0; i < mean_bins; ++i)
      table.row((i + 0.5) * 360 / mean_bins, v.measured.mean_turn[i], v.models[0].mean_turn[i],
                v.models[1].mean_turn[i]);
  return table;
}

}  // namespace freeplay
