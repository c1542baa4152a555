// freeplay advise: the least expensive settings that keep an error, measured on a scene.
#include <fmt/format.h>

#include <cmath>

#include "cli/command_line.hpp"
#include "cli/ending.hpp"
#include "cli/terminal.hpp"
#include "facade/simulation.hpp"
#include "io/scene/read_scene.hpp"
#include "mechanism/error.hpp"
#include "mechanism/scene.hpp"
#include "study/comparison/advice.hpp"
#include "study/comparison/settings.hpp"
#include "study/runs/perturb.hpp"
#include "study/verdicts/verdicts.hpp"

namespace freeplay::cli {
namespace {

using freeplay::shown;

struct AdviseRequest : Request {
  std::string scene;
  std::vector<std::string> overrides;
  double error = 1;  ///< %, requested error
};

void evaluated_on(const Advice& advice, const char* formulation, double duration) {
  const auto& r = advice.reference;
  if (!advice.by_events) {
    fmt::print("{}: {}; evaluated on the velocities at {:.4g} s\n", formulation,
               advice.to_the_end ? "no contact events" : "reference runs diverge at the first contact event",
               r.state_time);
    return;
  }
  fmt::print(
      "{}: evaluated on {} contact events (up to {:.4g} s of {:.4g} s{})\n", formulation,
      advice.to_the_end ? fmt::format("all {}", r.touches.size()) : fmt::format("{}", r.touches.size()),
      r.touches.back().t, duration, advice.to_the_end ? "" : ";\nreference runs diverge later");
  fmt::print("error: maximum of |dt|/interval, |dv|/v and |dP|/P over them (reference: {})\n",
             shown(r.accuracy));
}

void table(const Advice& advice) {
  fmt::print("  {:<30}{:>9}{:>15}{:>9}{:>7}{:>8}\n", "setting", "error, %", "accurate to, s", "rhs", "Jacob.",
             "CPU ms");
  for (std::size_t i = 0; i < advice.tried.size(); ++i) {
    const auto& m = advice.tried[i];
    const double error = advice.by_events ? m.errors.events : m.errors.state;
    const char* const why = m.dearer                                      ? "skipped"
                            : m.ending.status == Ending::Status::finished ? nullptr
                                                                          : "stopped";
    fmt::print("{} {:<30}{:>9}{:>15}{:>9}{:>7}{:>8.3g}\n", static_cast<int>(i) == advice.chosen ? '>' : ' ',
               m.setting.label(), why ? why : shown(100 * error),
               advice.by_events && m.kept_to == m.kept_to ? fmt::format("{:.3g}", m.kept_to) : "-",
               m.work.rhs, m.work.jacobians, 1e3 * m.cpu);
  }
}

/// Prints what was measured for the chosen setting, and its limits.
void promise(const Advice& advice, double error) {
  std::string keys, text;
  for (const auto& k : advice.tried[advice.chosen].setting.keys()) keys += "\n  --set " + k;
  text = fmt::format(
      "chosen: the cheapest setting with an error below half of {:.3g} % (cost: right-hand sides + 10 "
      "Jacobians); -: stopped at its first wrong or missing contact event; skipped: more expensive than an "
      "accurate one{}\n",
      100 * error, keys);
  if (advice.by_events)
    text += fmt::format("measured: each of the {} contact events to t = {:.4g} s within {:.3g} %\n",
                        advice.reference.touches.size(), advice.reference.touches.back().t, 100 * error);
  if (!advice.to_the_end && advice.statistics.empty())
    text +=
        "not assessed: later motion; single contact events are unpredictable there, and perturbed starts "
        "give no statistics\n";
  for (const auto& s : advice.statistics)
    text += fmt::format("  {}: {:.3g}, error {:.2g} ± {:.2g} %; scatter of one run {:.2g} %\n", s.name,
                        s.reference, 100 * s.difference, 100 * s.error, 100 * s.scatter);
  if (!advice.statistics.empty())
    text +=
        advice.promised() <= error
            ? fmt::format(
                  "measured: these statistics of the whole run within {:.2g} % (difference and two "
                  "standard errors)\n",
                  100 * advice.promised())
            : fmt::format("not shown: {:.3g} % for these statistics; their sampling error allows {:.2g} %\n",
                          100 * error, 100 * advice.promised());
  fmt::print("{}", wrapped(text));
}

/// The chosen setting for the verdict.
ChosenSetting chosen(const Advice& advice, const char* formulation, double duration) {
  if (advice.chosen < 0) return {formulation, ""};
  const auto& m = advice.tried[advice.chosen];
  const auto& r = advice.reference;
  return {formulation,
          m.setting.label(),
          m.cpu,
          advice.by_events ? r.touches.back().t : r.state_time,
          advice.to_the_end,
          advice.statistics.empty() ? NAN : advice.promised(),
          duration};
}

int advise(const AdviseRequest& request) {
  const auto scene = open_scene(request.scene, request.overrides);
  auto with = request.conduct();
  with.matched = false;  // as `run` uses it
  int status = 1;
  std::vector<ChosenSetting> settings;
  for (const auto& [family, name] : families) {
    const char* const formulation = name;
    Progress progress;
    Advice advice;
    try {
      advice = freeplay::advise(*scene, family, request.error / 100, with,
                                [&](double done) { progress.show(formulation, done); });
    } catch (const AlikeStarts&) {
      throw;
    } catch (const ModelError& e) {
      fmt::print("{}: not available: {}\n\n", formulation, e.what());
      continue;
    }
    progress.clear();
    if (request.stop()) return interrupted(Kept::nothing);
    if (advice.tried.empty()) {
      fmt::print("{}: no reference: {}\n\n", formulation, advice.reference.ending.reason);
      continue;
    }
    evaluated_on(advice, formulation, scene->run.duration);
    table(advice);
    for (const auto& [setting, s] : advice.refused)
      fmt::print("{}",
                 wrapped(fmt::format(
                     "rejected: {} reproduces all contact events, but {} of the whole run is off by {:.2g} "
                     "± {:.2g} %\n",
                     setting.label(), s.name, 100 * s.difference, 100 * s.error)));
    if (advice.chosen < 0) {
      fmt::print("no setting reaches {:.3g} %\n", request.error);
    } else {
      promise(advice, request.error / 100);
      status = 0;
    }
    settings.push_back(chosen(advice, formulation, scene->run.duration));
    fmt::print("({:.1f} s)\n\n", advice.seconds);
  }
  fmt::print("{}", wrapped(verdict(settings, request.error / 100, request.scene) + "\n", 0));
  return status;
}

}  // namespace

void advise_verb(Program& program) {
  auto [options, request] = program.verb(
      "advise", "find the cheapest numerical settings that reach an accuracy for this scene", advise);
  options.scene(request.scene).required();
  options.set(request.overrides);
  options.add("--error", request.error, "accepted error in per cent, as 1% or 1")
      .percentage([](double x) { return x > 0; }, "must be greater than 0 per cent, as 1% or 1")
      .takes("PERCENT");
}

}  // namespace freeplay::cli
