#include "study/runs/case_run.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "facade/identify.hpp"
#include "facade/simulation.hpp"
#include "io/files/escaping.hpp"
#include "io/scene/read_scene.hpp"
#include "io/scene/read_section.hpp"
#include "io/scene/scene_text.hpp"
#include "io/scene/toml_text.hpp"
#include "mechanism/scene.hpp"
#include "simulation/clock.hpp"
#include "study/runs/perturb.hpp"
#include "study/runs/turns.hpp"

namespace freeplay {
namespace {

/// Sets the study's contacts, or all contacts of the scene: the first and the others, −1: none.
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

/// Sets the turn of the study: the period that it states, or that of the scene's excitation.
/// Without one the speed is 0.
void set_turn(const Study& study, const Scene& scene, TurnRules& rules) {
  const auto* drive = main_drive(scene.mechanism);
  rules.speed = rules.crank_start = 0;
  if (!study.length.period && drive && drive->speed != 0) {
    rules.speed = drive->speed;
    rules.crank_start = drive->initial_angle;
  } else if (const auto period = study.length.period ? study.length.period : drive_period(scene)) {
    rules.speed = 2 * std::numbers::pi / *period;
  }
}

bool turns_at_a_speed(const Scene& scene) {
  const auto* drive = main_drive(scene.mechanism);
  return drive && drive->speed != 0;
}

/// Returns f(); a SceneError about a key that the study sets becomes one with its position in the study.
template <class F>
auto in_place(const Study& study, F f) try {
  return f();
} catch (const SceneError& e) {
  throw in_study(study, e);
}

}  // namespace

std::vector<Case> cases(const Study& study) {
  std::vector<Case> all;
  const auto list = cells(study);
  for (const auto& variant : study.variants) {
    const auto text = in_place(study, [&] {
      return std::make_shared<const SceneText>(read_text(variant.scene), variant.scene.string(),
                                               variant.overrides, study.reach == Reach::anywhere);
    });
    for (const auto& cell : list) {
      Case one{variant.name,        "",
               cell.values,         0,
               variant.revolutions, variant.scene,
               variant.overrides,   variant.sampling,
               variant.noise,       text};
      one.overrides.insert(one.overrides.end(), cell.overrides.begin(), cell.overrides.end());
      for (const auto& formulation : variant.formulations)
        for (int start = 0; start < variant.starts; ++start) {
          one.formulation = formulation;
          one.start = start;
          all.push_back(one);
        }
    }
  }
  return all;
}

namespace {

/// The scene as its file and the case's overrides state it.
Scene stated(const Study& study, const Case& one) {
  if (!one.text) return read_scene(one.scene, one.overrides, study.reach == Reach::anywhere);
  auto text = *one.text;
  for (auto i = text.options().size(); i < one.overrides.size(); ++i) text.set(one.overrides[i]);
  return text.read();
}

/// The scene of a case, with the duration of the study and the scene's own start.
Scene unmoved(const Study& study, const Case& one) {
  return in_place(study, [&] {
    auto scene = stated(study, one);
    TurnRules rules;
    set_turn(study, scene, rules);
    if (study.length.duration) {
      scene.run.discard = study.length.discard_time.value_or(0);
      scene.run.duration = scene.run.discard + *study.length.duration;
    } else if (rules.speed != 0) {
      const double turn = 2 * std::numbers::pi / std::abs(rules.speed);
      scene.run.discard = study.length.discard * turn;
      scene.run.duration = (study.length.discard + one.revolutions) * turn;
    } else if (study.length.in_periods) {
      throw error_at(study, {"revolutions"},
                     fmt::format("counts periods, as discard does, and {} has no drive with a period: give "
                                 "period, or duration and discard_time (s)",
                                 scene.file.string()));
    }
    return scene;
  });
}

/// As identity(), of the case's scene.
Identity identity_of(const Study& study, const Case& one, Scene scene, const Conduct& conduct) {
  scene.mechanism.title.clear();  // a run does not depend on it
  return located_in(scene, [&] {
    auto found = identify(scene, one.formulation, study.matched && conduct.matched);
    found.given = settings_text(study) + fmt::format("variant = {}\nvalues = {}\n", toml_quoted(one.variant),
                                                     toml_numbers(one.values));
    if (one.sampling > 0) found.given += fmt::format("sampling = {}\n", toml_number(one.sampling));
    if (one.noise > 0) found.given += fmt::format("noise = {}\n", toml_number(one.noise));
    return found;
  });
}

}  // namespace

Identity identity(const Study& study, const Case& one, const Conduct& conduct) {
  return identity_of(study, one, unmoved(study, one), conduct);
}

namespace {

/// The scene with the case's perturbed start.
Scene moved(const Study& study, const Case& one, const Scene& scene, const Conduct& conduct) {
  if (!differ(scene, study.starts.perturbation)) return scene;
  if (scene.run.start == RunOptions::Start::equilibrium)
    throw SceneError(fmt::format("{}: starts in equilibrium, which cannot be perturbed; use study.play = 0",
                                 scene.file.string()));
  return perturbed(scene, ideal_pose(scene, conduct.stop, *conduct.shared), conduct.stop, study.starts.seed,
                   one.start, study.starts.perturbation);
}

}  // namespace

RunnableCase require_runnable(const Study& study, const Case& one, const Conduct& conduct) {
  const auto scene = unmoved(study, one);
  RunnableCase found{identity_of(study, one, scene, conduct), differ(scene, study.starts.perturbation)};
  TurnRules rules;
  channels(study, scene, rules);
  located_in(scene, [&] {
    Simulation simulation(
        moved(study, one, scene, conduct), one.formulation,
        {.matched = study.matched && conduct.matched, .stop = conduct.stop, .checked = true});
    set_contacts(study, scene, simulation.layout().contacts, rules);
    require_columns(study, scene, simulation, counted_time(study, scene));
  });
  return found;
}

CountedTime counted_time(const Study& study, const Scene& scene) {
  TurnRules rules;
  set_turn(study, scene, rules);
  return {scene.run.discard, scene.run.duration,
          rules.speed != 0 ? 2 * std::numbers::pi / std::abs(rules.speed) : 0};
}

bool has_starts(const Study& study, const Case& one) {
  const auto scene = unmoved(study, one);
  return differ(scene, study.starts.perturbation);
}

void require_signal(const Study& study, const char* by) {
  const auto lacks = [&](const char* key, const char* what) {
    return error_at(study, {key}, fmt::format("{} needs {}", by, what));
  };
  if (study.accelerometer.empty()) throw lacks("accelerometer", "an accelerometer as signal");
  if (study.joints.size() != 1) throw lacks("joint", "one joint for flights and impacts");
  if (!turns_at_a_speed(*open_scene(study.scene, {}, study.reach == Reach::anywhere)))
    throw lacks("scene", "a scene with a drive of prescribed speed, to count revolutions");
}

namespace {

/// The turns of the file that a measure compares the run with; null if the scene's crank has another speed
/// than the measured one. `ideal_maximum`: see read_measurement().
std::shared_ptr<const MeasuredTurns> measured_turns(const Study& study, const Measure& measure,
                                                    const Scene& scene, double ideal_maximum,
                                                    const Conduct& conduct) {
  const auto* drive = main_drive(scene.mechanism);
  if (!drive || drive->speed == 0)
    throw error_at(study, {"calibrate"}, "a waveform needs a scene with a drive of prescribed speed");
  // The file is of one crank speed: that of the study's scene with the target's keys.
  const auto own = open_scene(study.scene, measure.overrides, study.reach == Reach::anywhere);
  const auto* measured = main_drive(own->mechanism);
  if (!measured || measured->speed != drive->speed) return nullptr;
  return conduct.shared->files({measure.digest, drive->speed}, [&] {
    return std::make_shared<const MeasuredTurns>(turns_of(
        read_measurement(measure.waveform, drive->speed, ideal_maximum, study.accelerometer), drive->speed));
  });
}

}  // namespace

Scene scene_of(const Study& study, const Case& one, const Conduct& conduct) {
  return moved(study, one, unmoved(study, one), conduct);
}

struct CaseRun::Parts {
  Parts(const Study& s, const Case& one, const Conduct& c, SharedCompilation* compilation)
      : study(s), stop(c.stop), given(unmoved(s, one)), instruments(instruments_of(s, one)) {
    scene = moved(s, one, given, c);
    set_turn(s, scene, rules);
    rules.discard = scene.run.discard;
    rules.thresholds = s.thresholds;
    auto options = compilation ? compilation->options(scene, one.formulation) : SimulationOptions{};
    options.matched = s.matched && c.matched;
    options.stop = c.stop;
    options.checked = one.sampling == 0;  // a sampling of the study is not checked yet
    simulation.emplace(scene, one.formulation, options);
    set_contacts(s, scene, simulation->layout().contacts, rules);
    // The comparison with the ideal mechanism requires a motion whose period does not depend on the
    // clearance.
    rules.ideal_maximum = instruments.channel >= 0 && turns_at_a_speed(scene)
                              ? ideal_maximum(s, given, one.formulation, c)
                              : std::nan("");
    meter.emplace(rules);
    feed.emplace(*meter, instruments.channel, instruments.lvdt, instruments.every,
                 SampleNoise(one.noise, s.starts.seed, one.start));
    measurer.emplace(s, scene, simulation->layout(), counted_time(s, scene));
    for (const auto& m : s.measures)
      measured.push_back(m.waveform.empty() ? nullptr : measured_turns(s, m, scene, rules.ideal_maximum, c));
    cpu += thread_seconds();
  }

  struct Instruments {
    int channel, lvdt, every;
  };
  /// The instruments of the study. Sets their sampling in the scene and the rules.
  Instruments instruments_of(const Study& s, const Case& one) {
    const auto [channel, lvdt] = channels(s, given, rules);
    Instruments found{channel, lvdt, 1};
    // No coarser than the instrument's own rate, which its filter may need.
    if (one.sampling > 0 && channel >= 0) {
      auto& own = given.instruments[channel].sampling;
      found.every = static_cast<int>(std::ceil(own / one.sampling * (1 - 1e-9)));
      own = found.every * one.sampling;
      if (lvdt >= 0) given.instruments[lvdt].sampling = own;
      rules.sampling = own;
    }
    return found;
  }
  /// J, in contacts since the start.
  double lost() const {
    const auto l = simulation->ledger();
    return l.contact + l.friction + l.film;
  }

  double cpu = -thread_seconds();  // s, of this run
  const Study& study;
  StopToken stop;
  TurnRules rules;
  Scene given;  // with the scene's own start
  Instruments instruments;
  Scene scene;
  std::optional<Simulation> simulation;
  std::optional<TurnMeter> meter;
  std::optional<Feed> feed;
  std::optional<Measurer> measurer;
  std::vector<std::shared_ptr<const MeasuredTurns>> measured;  // of each measure; null: no waveform
  bool discarded = false;
  double before = 0;  // J, lost in the discarded time
  CaseResult result;
};

CaseRun::CaseRun(const Study& study, const Case& one, const Conduct& conduct, SharedCompilation* compilation)
    : it_(std::make_unique<Parts>(study, one, conduct, compilation)) {}
CaseRun::~CaseRun() = default;
Simulation& CaseRun::simulation() { return *it_->simulation; }
double CaseRun::next_shown() const { return it_->measurer->next_shown(); }
std::vector<Observer*> CaseRun::followers() const { return it_->measurer->followers(); }
CaseResult& CaseRun::made() { return it_->result; }

RunRequest CaseRun::request() {
  auto& p = *it_;
  RunRequest request{.until = p.discarded ? p.scene.run.duration : p.rules.discard,
                     .observers = {&*p.feed},
                     .keep_events = false,
                     .stop = p.stop};
  for (auto* observer : p.measurer->observers()) request.observers.push_back(observer);
  return request;
}

bool CaseRun::take(Result run) {
  auto& p = *it_;
  p.cpu += run.cpu_seconds;
  const bool finished = run.ending.status == Ending::Status::finished;
  if (!p.discarded) {
    p.before = p.lost();
    p.discarded = true;
    if (finished) return true;
  }
  const double began = thread_seconds();
  auto& result = p.result;
  result.ending = run.ending;
  result.notes = run.notes;
  result.work = run.work;
  if (finished) {
    p.feed->finish();
    result.metrics = p.meter->finish(p.scene.run.duration, p.lost() - p.before);
    result.contacts = p.simulation->layout().contacts;
    result.measured = p.measurer->finish(std::move(run));
    for (std::size_t i = 0; i < p.measured.size(); ++i)
      if (p.measured[i])
        result.measured[i].value =
            waveform_difference(*p.measured[i], result.metrics.turns, p.study.measures[i].tolerance);
  }
  result.cpu_seconds = p.cpu + thread_seconds() - began;
  return false;
}

CaseResult run_case(const Study& study, const Case& one, const Conduct& conduct) {
  CaseRun run(study, one, conduct);
  run_alone(run);
  return std::move(run.made());
}

}  // namespace freeplay
