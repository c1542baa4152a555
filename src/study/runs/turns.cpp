#include "study/runs/turns.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "facade/identify.hpp"
#include "facade/simulation.hpp"
#include "io/files/escaping.hpp"
#include "io/scene/read_section.hpp"
#include "mechanism/scene.hpp"

namespace freeplay {
namespace {

int instrument(const Study& study, const Scene& scene, const std::string& name, Instrument::Kind kind,
               const char* key) {
  for (std::size_t i = 0; i < scene.instruments.size(); ++i)
    if (scene.instruments[i].name == name && scene.instruments[i].kind == kind) return static_cast<int>(i);
  std::vector<std::string> names;
  for (const auto& i : scene.instruments)
    if (i.kind == kind) names.push_back(i.name);
  throw error_at(
      study, {key},
      fmt::format("\"{}\" is not an instrument of {}; {}", visible(name), scene.file.string(),
                  names.empty() ? "it has none" : fmt::format("it has {}", fmt::join(names, ", "))));
}

}  // namespace

std::pair<int, int> channels(const Study& study, const Scene& scene, TurnRules& rules) {
  const int a = study.accelerometer.empty() ? -1
                                            : instrument(study, scene, study.accelerometer,
                                                         Instrument::Kind::accelerometer, "accelerometer");
  const int x = study.position.empty()
                    ? -1
                    : instrument(study, scene, study.position, Instrument::Kind::lvdt, "position");
  if (a >= 0 || x >= 0) rules.sampling = scene.instruments[a >= 0 ? a : x].sampling;
  if (x >= 0 && scene.instruments[x].sampling != rules.sampling)
    throw SceneError(
        fmt::format("{}: accelerometer and position must have the same sampling", scene.file.string()));
  return {a, x};
}

namespace {

/// Time until the initial transient of an accelerometer has decayed to 10⁻⁶, s: its slowest pole
/// has the real part −ω_c sin(π/(2n)).
double settling(const Instrument& i) {
  const double pi = std::numbers::pi;
  return i.bandwidth > 0 ? std::log(1e6) / (2 * pi * i.bandwidth * std::sin(pi / (2 * i.order))) : 0;
}

/// The scene with ideal joints, for one turn after its instruments have settled. Sets `rules`
/// accordingly.
Scene ideal_scene(const Study& study, const Scene& scene, TurnRules& rules) {
  const auto* drive = main_drive(scene.mechanism);
  const auto [channel, lvdt] = channels(study, scene, rules);
  rules.speed = drive->speed;
  rules.crank_start = drive->initial_angle;
  rules.joint = -1;
  const double turn = 2 * std::numbers::pi / std::abs(drive->speed);
  rules.discard = turn * std::max(1.0, std::ceil(settling(scene.instruments[channel]) / turn));
  Scene ideal = scene;
  ideal.mechanism = idealised(scene.mechanism);
  ideal.run.duration = rules.discard + turn + 2 / rules.sampling;
  ideal.run.discard = 0;
  ideal.run.start = RunOptions::Start::assembled;
  for (auto& i : ideal.instruments) i.noise.reset();
  return ideal;
}

TurnMetrics turn_of(const Study& study, const Scene& ideal, const TurnRules& rules,
                    const std::string& formulation, const Conduct& conduct) {
  TurnRules same;
  const auto [channel, lvdt] = channels(study, ideal, same);
  Simulation simulation(ideal, formulation,
                        {.matched = study.matched && conduct.matched, .stop = conduct.stop});
  TurnMeter meter(rules);
  Feed feed(meter, channel, lvdt);
  const auto run = simulation.run({.observers = {&feed}, .keep_events = false, .stop = conduct.stop});
  if (run.ending.status == Ending::Status::interrupted) throw Interrupted();
  return meter.finish(simulation.t(), std::nan(""));  // NaN for a run that did not finish
}

}  // namespace

TurnMetrics ideal_metrics(const Study& study, const Scene& scene, const std::string& formulation,
                          const Conduct& conduct) {
  TurnRules rules;
  const auto ideal = ideal_scene(study, scene, rules);
  return turn_of(study, ideal, rules, formulation, conduct);
}

double ideal_maximum(const Study& study, const Scene& scene, const std::string& formulation,
                     const Conduct& conduct) {
  TurnRules rules;
  const auto ideal = ideal_scene(study, scene, rules);
  auto identity = identify(ideal, formulation, study.matched && conduct.matched);
  identity.given += "accelerometer = " + study.accelerometer + "\n";
  return conduct.shared->ideal_maxima(identity.digest(), [&] {
    return turn_of(study, ideal, rules, formulation, conduct).value[TurnMetrics::peak_max];
  });
}

}  // namespace freeplay
