#include "study/case_run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <numbers>

#include "sim/recorder.hpp"

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
  return fmt::format("{}|{}|{}|{}|{}|{}|{}|{}|{}|{}|{}|{}|{}|{}|{}|{}|{}", one.formulation, one.start,
                     one.revolutions, study.discard, study.seed, study.matched, study.perturbation.turn,
                     study.perturbation.play, study.flight_angle, study.impact_speed, study.line_share,
                     study.joint, study.accelerometer, study.position, one.variant,
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

double ideal_maximum(const Study& study, const Scene& scene, const Makers& makers) {
  const auto channel = static_cast<std::size_t>(
      instrument(scene, study.accelerometer, Instrument::Kind::accelerometer, "accelerometer"));
  const double turn = 2 * std::numbers::pi / std::abs(main_drive(scene.mechanism)->speed);
  Scene ideal = scene;
  ideal.mechanism = idealised(scene.mechanism);
  ideal.run = {2 * turn, 0, RunOptions::Start::assembled, {}};
  for (auto& i : ideal.instruments) i.noise.reset();
  const System system(ideal.mechanism);
  const auto formulation = makers.penalty(ideal, system, assemble(ideal.mechanism, ideal.run.start));
  Recorder recorder(ideal, system, std::nullopt);
  double greatest = 0;
  recorder.on_sample = [&](std::size_t i, double t, double value) {
    if (i == channel && t > turn) greatest = std::max(greatest, std::abs(value));
  };
  if (formulation->run(ideal.run.duration, recorder).status == Ending::Status::failed) return std::nan("");
  return greatest;
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
  const int channel =
      instrument(scene, study.accelerometer, Instrument::Kind::accelerometer, "accelerometer");
  const int lvdt =
      study.position.empty() ? -1 : instrument(scene, study.position, Instrument::Kind::lvdt, "position");
  rules.sampling = scene.instruments[channel].sampling;
  if (lvdt >= 0 && scene.instruments[lvdt].sampling != rules.sampling)
    throw SceneError(
        fmt::format("{}: accelerometer and position must have the same sampling", scene.file.string()));

  const System system(scene.mechanism);
  rules.joint = -1;
  for (int k = 0; k < system.contacts(); ++k)
    if (system.contact_facts(k).name == study.joint) rules.joint = k;
  if (rules.joint < 0)
    throw SceneError(
        fmt::format("{}: the study's joint = \"{}\" has no clearance", scene.file.string(), study.joint));
  rules.ideal_maximum = ideal_maximum(study, scene, makers);

  const auto formulation =
      makers.of(one.formulation, study.matched)(scene, system, assemble(scene.mechanism, scene.run.start));
  Recorder recorder(scene, system, std::nullopt);
  TurnMeter meter(rules);
  recorder.on_event = [&](const ContactEvent& e) { meter.event(e); };
  recorder.on_sample = [&](std::size_t i, double t, double value) {
    if (static_cast<int>(i) == channel) meter.acceleration(t, value);
    if (static_cast<int>(i) == lvdt) meter.position(t, value);
  };
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
  result.notes = std::move(summary.notes);
  for (double x : summary.final_state.q)
    if (!std::isfinite(x)) result.ending = {Ending::Status::failed, "the state is not finite"};
  if (result.ending.status == Ending::Status::finished) result.metrics = meter.finish(lost() - before);
  result.work = formulation->work();
  result.cpu_seconds = thread_seconds() - began;
  return result;
}

}  // namespace freeplay
