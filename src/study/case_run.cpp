#include "study/case_run.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "facade/identify.hpp"
#include "facade/simulation.hpp"
#include "io/located.hpp"
#include "io/toml_value.hpp"
#include "model/scene.hpp"
#include "sim/clock.hpp"

namespace freeplay {
namespace {

int instrument(const Study& study, const Scene& scene, const std::string& name, Instrument::Kind kind,
               const char* key) {
  for (std::size_t i = 0; i < scene.instruments.size(); ++i)
    if (scene.instruments[i].name == name && scene.instruments[i].kind == kind) return static_cast<int>(i);
  std::vector<std::string> names;
  for (const auto& i : scene.instruments)
    if (i.kind == kind) names.push_back(i.name);
  throw SceneError(fmt::format(
      "{}: the study's {} = \"{}\" is no such instrument of {}; {}", study.file.string(), key, name,
      scene.file.string(), names.empty() ? "it has none" : fmt::format("it has {}", fmt::join(names, ", "))));
}

/// The study's accelerometer and LVDT (−1: none) among the scene's instruments; sets the rules' sampling.
std::pair<int, int> channels(const Study& study, const Scene& scene, TurnRules& rules) {
  const int a =
      instrument(study, scene, study.accelerometer, Instrument::Kind::accelerometer, "accelerometer");
  const int x = study.position.empty()
                    ? -1
                    : instrument(study, scene, study.position, Instrument::Kind::lvdt, "position");
  rules.sampling = scene.instruments[a].sampling;
  if (x >= 0 && scene.instruments[x].sampling != rules.sampling)
    throw SceneError(
        fmt::format("{}: accelerometer and position must have the same sampling", scene.file.string()));
  return {a, x};
}

/// The study's joint among those with clearance.
int contact(const Study& study, const Scene& scene, const std::vector<std::string>& names) {
  const auto found = std::ranges::find(names, study.joint);
  if (found != names.end()) return static_cast<int>(found - names.begin());
  throw SceneError(fmt::format(
      "{}: the study's joint = \"{}\" has no clearance in {}; {}", study.file.string(), study.joint,
      scene.file.string(), names.empty() ? "no joint has" : fmt::format("{} have", fmt::join(names, ", "))));
}

/// Gives a meter the samples of two channels, of the accelerometer each `every`-th, and events.
class Feed final : public Observer {
 public:
  Feed(TurnMeter& meter, int acceleration, int position, int every = 1)
      : meter_(meter), acceleration_(acceleration), position_(position), every_(every) {}
  Wants wants() const override { return {.samples = true, .steps = false}; }
  void event(const Event& e) override { meter_.event(e); }
  void sample(std::size_t channel, double t, double value) override {
    if (static_cast<int>(channel) == acceleration_ && seen_++ % every_ == 0) meter_.acceleration(t, value);
    if (static_cast<int>(channel) == position_) meter_.position(t, value);
  }
  void end(const RunEnd& end) override {
    held_back_.assign(end.held_back.begin(), end.held_back.end());
    for (std::size_t k = 0; k < end.undecided_since.size(); ++k)
      if (!std::isnan(end.undecided_since[k])) {
        ContactEvent open;  // touched, and not known to be an impact or a lasting contact
        open.t = end.undecided_since[k];
        open.contact = static_cast<int>(k);
        open.kind = EventKind::contact;
        held_back_.push_back(open);
      }
    std::ranges::sort(held_back_, {}, &ContactEvent::t);
  }
  /// After the run: events that a touch before them still held back.
  void finish() {
    for (const auto& e : held_back_) meter_.event(e);
  }

 private:
  TurnMeter& meter_;
  int acceleration_, position_, every_;
  long seen_ = 0;
  std::vector<ContactEvent> held_back_;
};

/// s, until what an accelerometer began with has decayed to a millionth: its slowest pole has the real part
/// −ω_c sin(π/(2n)).
double settling(const Instrument& i) {
  const double pi = std::numbers::pi;
  return i.bandwidth > 0 ? std::log(1e6) / (2 * pi * i.bandwidth * std::sin(pi / (2 * i.order))) : 0;
}

}  // namespace

std::vector<Case> cases(const Study& study) {
  std::vector<Case> all;
  for (const auto& variant : study.variants) {
    std::vector<std::size_t> at(study.axes.size(), 0);
    for (bool more = true; more;) {
      Case one{variant.name,    "", {}, 0, variant.revolutions, variant.scene, variant.overrides,
               variant.sampling};
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

namespace {

/// The scene of a case, as long as the study asks, at the start that the scene gives.
Scene unmoved(const Study& study, const Case& one) try {
  auto scene = read_scene(one.scene, one.overrides);
  const auto* drive = main_drive(scene.mechanism);
  if (!drive || drive->speed == 0)
    throw SceneError(fmt::format("{}: a study needs a drive that turns at a prescribed speed, to count turns",
                                 scene.file.string()));
  const double turn = 2 * std::numbers::pi / std::abs(drive->speed);
  scene.run.discard = study.discard * turn;
  scene.run.duration = (study.discard + one.revolutions) * turn;
  return scene;
} catch (const SceneError& e) {
  throw in_study(study, e);
}

}  // namespace

Identity identity(const Study& study, const Case& one, const Conduct& conduct) {
  auto scene = unmoved(study, one);
  scene.mechanism.title.clear();  // says nothing that a run depends on
  try {
    auto found = identify(scene, one.formulation, study.matched && conduct.matched);
    found.given = settings_text(study) + fmt::format("variant = {}\nvalues = {}\n", toml_quoted(one.variant),
                                                     toml_numbers(one.values));
    if (one.sampling > 0) found.given += fmt::format("sampling = {}\n", toml_number(one.sampling));
    return found;
  } catch (const SceneError&) {
    throw;
  } catch (const ModelError& e) {
    throw located(scene, e);
  }
}

void require_runnable(const Study& study, const Case& one, const Conduct& conduct) {
  const auto scene = unmoved(study, one);
  TurnRules rules;
  channels(study, scene, rules);
  try {
    const Simulation simulation(scene, one.formulation,
                                {.matched = study.matched && conduct.matched, .stop = conduct.stop});
    contact(study, scene, simulation.layout().contacts);
  } catch (const SceneError&) {
    throw;
  } catch (const ModelError& e) {
    throw located(scene, e);
  }
}

std::string run_key(Identity all_starts, int start) {
  all_starts.given += fmt::format("start = {}\n", start);
  return all_starts.digest();
}

Scene scene_of(const Study& study, const Case& one, const Conduct& conduct) {
  return perturbed(unmoved(study, one), conduct.stop, study.seed, one.start, study.perturbation);
}

TurnMetrics ideal_turn(const Study& study, const Scene& scene, const std::string& formulation,
                       const Conduct& conduct) {
  const auto* drive = main_drive(scene.mechanism);
  TurnRules rules;
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
  Simulation simulation(ideal, formulation,
                        {.matched = study.matched && conduct.matched, .stop = conduct.stop});
  TurnMeter meter(rules);
  Feed feed(meter, channel, lvdt);
  const auto run = simulation.run({.observers = {&feed}, .keep_events = false, .stop = conduct.stop});
  if (run.ending.status == Ending::Status::interrupted) throw Interrupted();
  return meter.finish(simulation.t(), std::nan(""));  // of a run that stopped early: NaN
}

double ideal_maximum(const Study& study, const Scene& scene, const std::string& formulation,
                     const Conduct& conduct) {
  return ideal_turn(study, scene, formulation, conduct).value[TurnMetrics::peak_max];
}

CaseResult run_case(const Study& study, const Case& one, const Conduct& conduct) {
  const double began = thread_seconds();
  Scene scene = scene_of(study, one, conduct);
  const auto* drive = main_drive(scene.mechanism);
  TurnRules rules;
  rules.discard = scene.run.discard;
  rules.speed = drive->speed;
  rules.crank_start = drive->initial_angle;
  rules.flight_angle = study.flight_angle;
  rules.impact_speed = study.impact_speed;
  rules.line_share = study.line_share;
  const auto [channel, lvdt] = channels(study, scene, rules);

  int every = 1;
  if (one.sampling > 0) {  // no coarser than the instrument's own, which its filter may need
    auto& own = scene.instruments[channel].sampling;
    every = static_cast<int>(std::ceil(own / one.sampling * (1 - 1e-9)));
    own = every * one.sampling;
    rules.sampling = own;
    if (lvdt >= 0) scene.instruments[lvdt].sampling = own;
  }
  Simulation simulation(scene, one.formulation,
                        {.matched = study.matched && conduct.matched, .stop = conduct.stop});
  rules.joint = contact(study, scene, simulation.layout().contacts);
  rules.ideal_maximum = ideal_maximum(study, scene, one.formulation, conduct);

  TurnMeter meter(rules);
  Feed feed(meter, channel, lvdt, every);
  RunRequest request{
      .until = rules.discard, .observers = {&feed}, .keep_events = false, .stop = conduct.stop};
  auto run = simulation.run(request);
  const auto lost = [&] {
    const auto l = simulation.ledger();
    return l.contact + l.friction + l.film;
  };
  const double before = lost();
  if (run.ending.status == Ending::Status::finished) {
    request.until = scene.run.duration;
    run = simulation.run(request);
  }
  CaseResult result;
  result.ending = run.ending;
  result.notes = run.notes;
  if (result.ending.status == Ending::Status::finished) {
    feed.finish();
    result.metrics = meter.finish(scene.run.duration, lost() - before);
  }
  result.work = run.work;
  result.cpu_seconds = thread_seconds() - began;
  return result;
}

}  // namespace freeplay
