// freeplay advise: the cheapest settings that keep an error, measured on a scene.
#include <fmt/format.h>

#include "cli/progress.hpp"
#include "cli/shown.hpp"
#include "cli/verb.hpp"
#include "facade/simulation.hpp"
#include "io/open_scene.hpp"
#include "model/error.hpp"
#include "study/tradeoff.hpp"

namespace freeplay::cli {
namespace {

struct AdviseRequest : Request {
  std::string scene;
  std::vector<std::string> overrides;
  double error = 1;  ///< %
};

int advise(const AdviseRequest& request) {
  const auto scene = open_scene(request.scene, request.overrides);
  auto with = request.conduct();
  with.matched = false;  // as `run` takes it
  int status = 1;
  for (const auto& [family, name] : families) {
    const char* const formulation = name;
    Progress progress;
    Advice advice;
    try {
      advice = freeplay::advise(*scene, family, request.error / 100, with,
                                [&](double done) { progress.show(formulation, done); });
    } catch (const ModelError& e) {
      fmt::print("{}: not available: {}\n\n", formulation, e.what());
      continue;
    }
    progress.clear();
    if (request.stop()) return 1;
    if (advice.tried.empty()) {
      fmt::print("{}: no reference: {}\n\n", formulation, advice.reference.ending.reason);
      continue;
    }
    if (advice.by_events)
      fmt::print("{}: judged by {} touches to {:.4g} s, reference known to {}\n", formulation,
                 advice.reference.touches.size(), advice.reference.horizon, shown(advice.reference.accuracy));
    else
      fmt::print("{}: no touches; judged by the velocities at {:.4g} s\n", formulation,
                 advice.reference.state_time);
    fmt::print("  {:<34}{:>10}{:>12}{:>12}{:>10}\n", "setting", "error, %", "rhs", "Jacobians", "CPU ms");
    for (std::size_t i = 0; i < advice.tried.size(); ++i) {
      const auto& m = advice.tried[i];
      const double error = advice.by_events ? m.errors.events : m.errors.state;
      fmt::print("{} {:<34}{:>10}{:>12}{:>12}{:>10.3g}\n", static_cast<int>(i) == advice.chosen ? '>' : ' ',
                 m.setting.label(),
                 m.ending.status == Ending::Status::finished ? shown(100 * error) : "stopped", m.work.rhs,
                 m.work.jacobians, 1e3 * m.cpu);
    }
    if (advice.chosen >= 0) {
      std::string keys;
      for (const auto& k : advice.tried[advice.chosen].setting.keys()) keys += " --set " + k;
      fmt::print(
          "the cheapest within {:.3g} % with a factor of two to spare, by right-hand sides and ten for each\n"
          "Jacobian (counts, not times; -: touches are missing):\n ",
          request.error);
      fmt::print("{}\n\n", keys);
      status = 0;
    } else {
      fmt::print("none stays within {:.3g} %\n\n", request.error);
    }
  }
  return status;
}

}  // namespace

void advise_verb(Program& program) {
  auto [options, request] =
      program.verb("advise", "name the cheapest settings that keep an error, measured on this scene", advise);
  options.scene(request.scene).required();
  options.set(request.overrides);
  options.add("--error", request.error, "greatest error, per cent (1% or 1)")
      .percentage([](double x) { return x > 0; }, "must be greater than 0 per cent, as 1% or 1");
}

}  // namespace freeplay::cli
