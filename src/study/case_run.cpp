#include "study/case_run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <numbers>

#include "sim/recorder.hpp"
#include "version.hpp"

namespace freeplay {
namespace {

double thread_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

int instrument(const Scene& scene, const std::string& name, Instrument::Kind kind, const char* key) {
  for (std::size_t i = 0; i < scene.instruments.size(); ++i)
    if (scene.instruments[i].name == name && scene.instruments[i].kind == kind) return static_cast<int>(i);
  throw SceneError(fmt::format("{}: the study's {} = \"{}\" is no such instrument of the scene",
                               scene.file.string(), key, name));
}

/// The study's accelerometer and LVDT (−1: none) among the scene's instruments; sets the rules' sampling.
std::pair<int, int> channels(const Study& study, const Scene& scene, TurnRules& rules) {
  const int a = instrument(scene, study.accelerometer, Instrument::Kind::accelerometer, "accelerometer");
  const int x =
      study.position.empty() ? -1 : instrument(scene, study.position, Instrument::Kind::lvdt, "position");
  rules.sampling = scene.instruments[a].sampling;
  if (x >= 0 && scene.instruments[x].sampling != rules.sampling)
    throw SceneError(
        fmt::format("{}: accelerometer and position must have the same sampling", scene.file.string()));
  return {a, x};
}

void feed(Recorder& recorder, TurnMeter& meter, int acceleration, int position) {
  recorder.on_sample = [&meter, acceleration, position](std::size_t i, double t, double value) {
    if (static_cast<int>(i) == acceleration) meter.acceleration(t, value);
    if (static_cast<int>(i) == position) meter.position(t, value);
  };
}

}  // namespace

std::vector<Case> cases(const Study& study) {
  std::vector<Case> all;
  for (const auto& variant : study.variants) {
    std::vector<std::size_t> at(study.axes.size(), 0);
    for (bool more = true; more;) {
      Case one{variant.name, "", {}, 0, variant.revolutions, variant.scene, variant.overrides};
      for (std::size_t a = 0; a < at.size(); ++a) {
        one.values.push_back(study.axes[a].values[at[a]]);
        one.overrides.push_back(fmt::format("{}={}", study.axes[a].key, one.values.back()));
      }
      for (const auto& formulation : variant.formulations)
        for (int start = 0; start < variant.starts; ++start) {
          one.formulation = formulation;
          one.start = start;
          all.push_back(one);
        }
      more = false;
      for (std::size_t a = 0; a < at.size() && !more; ++a) {
        more = ++at[a] < study.axes[a].values.size();
        if (!more) at[a] = 0;
      }
    }
  }
  return all;
}

std::string identity(const Study& study, const Case& one, const std::string& scene_text) {
  return fmt::format("{}|{}|{}|{}|{}|{}|{}|{}|{}|{}|{}|{}|{}|{}|{}|{}|{}|{}", commit, one.formulation,
                     one.start, one.revolutions, study.discard, study.seed, study.matched,
                     study.perturbation.turn, study.perturbation.play, study.flight_angle, study.impact_speed,
                     study.line_share, study.joint, study.accelerometer, study.position, one.variant,
                     fmt::join(one.overrides, ";"), scene_text);
}

Scene scene_of(const Study& study, const Case& one, const Makers& makers) {
  auto scene = read_scene(one.scene, one.overrides);
  const auto* drive = main_drive(scene.mechanism);
  if (!drive || drive->speed == 0)
    throw SceneError(fmt::format("{}: a study needs a drive that turns at a prescribed speed, to count turns",
                                 scene.file.string()));
  const double turn = 2 * std::numbers::pi / std::abs(drive->speed);
  scene.run.discard = study.discard * turn;
  scene.run.duration = (study.discard + one.revolutions) * turn;
  return perturbed(scene, makers.penalty, study.seed, one.start, study.perturbation);
}

TurnMetrics ideal_turn(const Study& study, const Scene& scene, const MakeFormulation& maker) {
  const auto* drive = main_drive(scene.mechanism);
  TurnRules rules;
  const auto [channel, lvdt] = channels(study, scene, rules);
  rules.speed = drive->speed;
  rules.crank_start = drive->initial_angle;
  rules.discard = 2 * std::numbers::pi / std::abs(drive->speed);
  Scene ideal = scene;
  ideal.mechanism = idealised(scene.mechanism);
  ideal.run.duration = 2 * rules.discard + 2 / rules.sampling;
  ideal.run.discard = 0;
  ideal.run.start = RunOptions::Start::assembled;
  for (auto& i : ideal.instruments) i.noise.reset();
  const System system(ideal.mechanism);
  const auto formulation = maker(ideal, system, assemble(ideal.mechanism, ideal.run.start));
  Recorder recorder(ideal, system, std::nullopt);
  TurnMeter meter(rules);
  feed(recorder, meter, channel, lvdt);
  formulation->run(ideal.run.duration, recorder);
  return meter.finish(0);  // of a run that stopped early: NaN
}

double ideal_maximum(const Study& study, const Scene& scene, const MakeFormulation& maker) {
  return ideal_turn(study, scene, maker).value[TurnMetrics::peak_max];
}

CaseResult run_case(const Study& study, const Case& one, const Makers& makers) {
  const double began = thread_seconds();
  const Scene scene = scene_of(study, one, makers);
  const auto* drive = main_drive(scene.mechanism);
  TurnRules rules;
  rules.discard = scene.run.discard;
  rules.speed = drive->speed;
  rules.crank_start = drive->initial_angle;
  rules.flight_angle = study.flight_angle;
  rules.impact_speed = study.impact_speed;
  rules.line_share = study.line_share;
  const auto [channel, lvdt] = channels(study, scene, rules);

  const System system(scene.mechanism);
  rules.joint = -1;
  for (int k = 0; k < system.contacts(); ++k)
    if (system.contact_facts(k).name == study.joint) rules.joint = k;
  if (rules.joint < 0)
    throw SceneError(
        fmt::format("{}: the study's joint = \"{}\" has no clearance", scene.file.string(), study.joint));
  const auto& maker = makers.of(one.formulation, study.matched);
  rules.ideal_maximum = ideal_maximum(study, scene, maker);

  const auto formulation = maker(scene, system, assemble(scene.mechanism, scene.run.start));
  Recorder recorder(scene, system, std::nullopt);
  TurnMeter meter(rules);
  recorder.on_event = [&](const ContactEvent& e) { meter.event(e); };
  feed(recorder, meter, channel, lvdt);
  CaseResult result;
  result.ending = formulation->run(rules.discard, recorder);
  const auto lost = [&] {
    const auto l = formulation->ledger();
    return l.contact + l.friction + l.film + l.damping;
  };
  const double before = lost();
  if (result.ending.status == Ending::Status::finished)
    result.ending = formulation->run(scene.run.duration, recorder);
  auto summary = summarise(scene, system, *formulation);
  refuse_not_finite(summary, result.ending);
  result.notes = std::move(summary.notes);
  if (result.ending.status == Ending::Status::finished) result.metrics = meter.finish(lost() - before);
  result.work = formulation->work();
  result.cpu_seconds = thread_seconds() - began;
  return result;
}

}  // namespace freeplay
