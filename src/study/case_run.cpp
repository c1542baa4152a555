#include "study/case_run.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "facade/identify.hpp"
#include "facade/simulation.hpp"
#include "io/located.hpp"
#include "io/open_scene.hpp"
#include "io/read_section.hpp"
#include "io/toml_value.hpp"
#include "io/visible.hpp"
#include "model/scene.hpp"
#include "sim/clock.hpp"
#include "study/design.hpp"

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
      fmt::format("\"{}\" is no such instrument of {}; {}", visible(name), scene.file.string(),
                  names.empty() ? "it has none" : fmt::format("it has {}", fmt::join(names, ", "))));
}

/// The study's accelerometer and LVDT (−1: none) among the scene's instruments; sets the rules' sampling.
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

/// The study's contacts among the scene's, or all of them: the first and the others, −1: none.
void set_contacts(const Study& study, const Scene& scene, const std::vector<std::string>& names,
                  TurnRules& rules) {
  std::vector<int> found;
  for (std::size_t k = 0; k < names.size(); ++k)
    if (study.joints.empty() || std::ranges::count(study.joints, names[k]) > 0)
      found.push_back(static_cast<int>(k));
  for (const auto& joint : study.joints)
    if (std::ranges::count(names, joint) == 0)
      throw error_at(
          study, {"joint"},
          fmt::format("\"{}\" has no clearance in {}; {}", visible(joint), scene.file.string(),
                      names.empty() ? "no joint has" : fmt::format("{} have", fmt::join(names, ", "))));
  rules.joint = found.empty() ? -1 : found.front();
  rules.others.clear();
  if (!found.empty()) rules.others.assign(found.begin() + 1, found.end());
}

/// A turn that the study counts by: of the period that it gives, or of what drives the scene; without one its speed is 0.
void set_turn(const Study& study, const Scene& scene, TurnRules& rules) {
  const auto* drive = main_drive(scene.mechanism);
  rules.speed = rules.crank_start = 0;
  if (!study.period && drive && drive->speed != 0) {
    rules.speed = drive->speed;
    rules.crank_start = drive->initial_angle;
  } else if (const auto period = study.period ? study.period : drive_period(scene)) {
    rules.speed = 2 * std::numbers::pi / *period;
  }
}

bool turns_at_a_speed(const Scene& scene) {
  const auto* drive = main_drive(scene.mechanism);
  return drive && drive->speed != 0;
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
  const auto list = cells(study);
  for (const auto& variant : study.variants)
    for (const auto& cell : list) {
      Case one{variant.name,    "", cell.values, 0, variant.revolutions, variant.scene, variant.overrides,
               variant.sampling};
      one.overrides.insert(one.overrides.end(), cell.overrides.begin(), cell.overrides.end());
      for (const auto& formulation : variant.formulations)
        for (int start = 0; start < variant.starts; ++start) {
          one.formulation = formulation;
          one.start = start;
          all.push_back(one);
        }
    }
  return all;
}

namespace {

/// The scene of a case, as long as the study asks, at the start that the scene gives.
Scene unmoved(const Study& study, const Case& one) try {
  auto scene = read_scene(one.scene, one.overrides, study.reach == Reach::anywhere);
  TurnRules rules;
  set_turn(study, scene, rules);
  if (study.duration) {
    scene.run.discard = study.discard_time.value_or(0);
    scene.run.duration = scene.run.discard + *study.duration;
  } else if (rules.speed != 0) {
    const double turn = 2 * std::numbers::pi / std::abs(rules.speed);
    scene.run.discard = study.discard * turn;
    scene.run.duration = (study.discard + one.revolutions) * turn;
  } else if (study.in_periods) {
    throw error_at(study, {},
                   fmt::format("revolutions and discard count periods, and nothing drives {} with one: give "
                               "period, or duration and discard_time (s)",
                               scene.file.string()));
  }
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
    Simulation simulation(scene, one.formulation,
                          {.matched = study.matched && conduct.matched, .stop = conduct.stop});
    set_contacts(study, scene, simulation.layout().contacts, rules);
    if (differ(scene, study.perturbation) && scene.run.start == RunOptions::Start::equilibrium)
      (void)scene_of(study, one, conduct);  // refuses it
    require_columns(study, scene, simulation, counted_time(study, scene));
  } catch (const SceneError&) {
    throw;
  } catch (const ModelError& e) {
    throw located(scene, e);
  }
}

CountedTime counted_time(const Study& study, const Scene& scene) {
  TurnRules rules;
  set_turn(study, scene, rules);
  return {scene.run.discard, scene.run.duration,
          rules.speed != 0 ? 2 * std::numbers::pi / std::abs(rules.speed) : 0};
}

bool has_starts(const Study& study, const Case& one) {
  const auto scene = unmoved(study, one);
  return differ(scene, study.perturbation);
}

void require_signal(const Study& study, const char* by) {
  const auto lacks = [&](const char* key, const char* what) {
    return error_at(study, {key}, fmt::format("{} needs {}", by, what));
  };
  if (study.accelerometer.empty()) throw lacks("accelerometer", "an accelerometer, whose signal it judges");
  if (study.joints.size() != 1) throw lacks("joint", "one joint, whose flights and impacts it judges");
  if (!turns_at_a_speed(*open_scene(study.scene, {}, study.reach == Reach::anywhere)))
    throw lacks("scene", "a scene with a drive that turns at a prescribed speed, to count turns");
}

std::string run_key(Identity all_starts, int start) {
  all_starts.given += fmt::format("start = {}\n", start);
  return all_starts.digest();
}

Scene scene_of(const Study& study, const Case& one, const Conduct& conduct) {
  auto scene = unmoved(study, one);
  if (!differ(scene, study.perturbation)) return scene;
  if (scene.run.start == RunOptions::Start::equilibrium)
    throw SceneError(
        fmt::format("{}: starts in equilibrium, from which its loose parts are not moved; take the study's "
                    "play = 0",
                    scene.file.string()));
  return perturbed(scene, conduct.stop, study.seed, one.start, study.perturbation);
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
  TurnRules rules;
  set_turn(study, scene, rules);
  rules.discard = scene.run.discard;
  rules.flight_angle = study.flight_angle;
  rules.impact_speed = study.impact_speed;
  rules.line_share = study.line_share;
  const auto [channel, lvdt] = channels(study, scene, rules);

  int every = 1;
  if (one.sampling > 0 && channel >= 0) {  // no coarser than the instrument's own, which its filter may need
    auto& own = scene.instruments[channel].sampling;
    every = static_cast<int>(std::ceil(own / one.sampling * (1 - 1e-9)));
    own = every * one.sampling;
    rules.sampling = own;
    if (lvdt >= 0) scene.instruments[lvdt].sampling = own;
  }
  Simulation simulation(scene, one.formulation,
                        {.matched = study.matched && conduct.matched, .stop = conduct.stop});
  set_contacts(study, scene, simulation.layout().contacts, rules);
  // What compares with the ideal mechanism needs a motion that repeats whatever the play.
  rules.ideal_maximum = channel >= 0 && turns_at_a_speed(scene)
                            ? ideal_maximum(study, scene, one.formulation, conduct)
                            : std::nan("");

  TurnMeter meter(rules);
  Feed feed(meter, channel, lvdt, every);
  RunRequest request{
      .until = rules.discard, .observers = {&feed}, .keep_events = false, .stop = conduct.stop};
  const Measurer measurer(study, scene, simulation.layout(), counted_time(study, scene));
  for (auto* observer : measurer.observers()) request.observers.push_back(observer);
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
    result.contacts = simulation.layout().contacts;
    result.measured = measurer.finish(run);
  }
  result.work = run.work;
  result.cpu_seconds = thread_seconds() - began;
  return result;
}

}  // namespace freeplay
