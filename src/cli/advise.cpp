// freeplay advise: the least expensive settings that keep an error, measured on a scene.
#include <fmt/format.h>

#include <cmath>

#include "cli/ending.hpp"
#include "cli/progress.hpp"
#include "cli/shown.hpp"
#include "cli/verb.hpp"
#include "cli/wrapped.hpp"
#include "facade/simulation.hpp"
#include "io/scene/open_scene.hpp"
#include "mechanism/error.hpp"
#include "mechanism/scene.hpp"
#include "study/comparison/advice.hpp"
#include "study/runs/perturb.hpp"

namespace freeplay::cli {
namespace {

struct AdviseRequest : Request {
  std::string scene;
  std::vector<std::string> overrides;
  double error = 1;  ///< %, requested error
};

void judged_by(const Advice& advice, const char* formulation, double duration) {
  const auto& r = advice.reference;
  if (!advice.by_events) {
    fmt::print("{}: {}; judged by the velocities at {:.4g} s\n", formulation,
               advice.to_the_end ? "no touches" : "fine runs part at the first touch", r.state_time);
    return;
  }
  fmt::print("{}: judged by {} touches to t = {:.4g} s of {:.4g} s, {}\n", formulation, r.touches.size(),
             r.touches.back().t, duration,
             advice.to_the_end ? "all there are" : "beyond which two\nfine runs part");
  fmt::print("error: greatest of |dt|/interval, |dv|/v and |dP|/P over them (reference: {})\n",
             shown(r.accuracy));
}

void table(const Advice& advice) {
  fmt::print("  {:<32}{:>9}{:>12}{:>10}{:>8}{:>9}\n", "setting", "error, %", "kept to, s", "rhs", "Jacob.",
             "CPU ms");
  for (std::size_t i = 0; i < advice.tried.size(); ++i) {
    const auto& m = advice.tried[i];
    const double error = advice.by_events ? m.errors.events : m.errors.state;
    const char* const why = m.dearer                                      ? "dearer"
                            : m.ending.status == Ending::Status::finished ? nullptr
                                                                          : "stopped";
    fmt::print("{} {:<32}{:>9}{:>12}{:>10}{:>8}{:>9.3g}\n", static_cast<int>(i) == advice.chosen ? '>' : ' ',
               m.setting.label(), why ? why : shown(100 * error),
               advice.by_events && m.kept_to == m.kept_to ? fmt::format("{:.3g}", m.kept_to) : "-",
               m.work.rhs, m.work.jacobians, 1e3 * m.cpu);
  }
}

/// Prints what the chosen setting guarantees, and its limits.
void promise(const Advice& advice, double error) {
  std::string keys, text;
  for (const auto& k : advice.tried[advice.chosen].setting.keys()) keys += "\n  --set " + k;
  text = fmt::format(
      "the cheapest of those that keep {:.3g} % with a factor of two to spare, by right-hand sides and ten for "
      "each Jacobian; a setting is stopped at its first touch that is off or missing (-), or when it has cost "
      "more than another that keeps it (dearer){}\n",
      100 * error, keys);
  if (advice.by_events)
    text += fmt::format("promised: each of the {} touches to t = {:.4g} s within {:.3g} %\n",
                        advice.reference.touches.size(), advice.reference.touches.back().t, 100 * error);
  if (!advice.to_the_end && advice.statistics.empty())
    text +=
        "not promised: what comes after; single touches mean nothing there, and no statistics can be taken "
        "from moved starts\n";
  for (const auto& s : advice.statistics)
    text += fmt::format("  {}: {:.3g}, off by {:.2g} ± {:.2g} %; one run scatters by {:.2g} %\n", s.name,
                        s.reference, 100 * s.difference, 100 * s.error, 100 * s.scatter);
  if (!advice.statistics.empty())
    text += advice.promised() <= error
                ? fmt::format("promised: these statistics of the whole run within {:.2g} %\n",
                              100 * advice.promised())
                : fmt::format(
                      "not promised: {:.3g} % of these statistics; their sampling error allows {:.2g} %\n",
                      100 * error, 100 * advice.promised());
  fmt::print("{}", wrapped(text));
}

int advise(const AdviseRequest& request) {
  const auto scene = open_scene(request.scene, request.overrides);
  auto with = request.conduct();
  with.matched = false;  // as `run` uses it
  int status = 1;
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
    judged_by(advice, formulation, scene->run.duration);
    table(advice);
    for (const auto& [setting, s] : advice.refused)
      fmt::print("{}",
                 wrapped(fmt::format(
                     "refused: {} keeps every touch, but {} of the whole run is off by {:.2g} ± {:.2g} %\n",
                     setting.label(), s.name, 100 * s.difference, 100 * s.error)));
    if (advice.chosen < 0) {
      fmt::print("none keeps {:.3g} %\n", request.error);
    } else {
      promise(advice, request.error / 100);
      status = 0;
    }
    fmt::print("({:.1f} s)\n\n", advice.seconds);
  }
  return status;
}

}  // namespace

void advise_verb(Program& program) {
  auto [options, request] =
      program.verb("advise", "name the cheapest settings that keep an error, measured on this scene", advise);
  options.scene(request.scene).required();
  options.set(request.overrides);
  options.add("--error", request.error, "greatest error, 1% or 1 for one per cent")
      .percentage([](double x) { return x > 0; }, "must be greater than 0 per cent, as 1% or 1")
      .takes("PERCENT");
}

}  // namespace freeplay::cli
