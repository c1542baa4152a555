// What a verb says about a scene before it runs: questions and notes about implausible values, on stderr,
// which do not stop a run or change its exit status; and the facts of the assembled mechanism.
#pragma once

#include <fmt/format.h>

#include <cmath>
#include <cstdio>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "cli/terminal.hpp"
#include "dynamics/assembly/mobility.hpp"
#include "mechanism/plausibility.hpp"
#include "mechanism/scene.hpp"
#include "values/state.hpp"

namespace freeplay::cli {

/// Question about a fixed step of more than 10 degrees of the main drive's turn. The error of
/// midpoint steps is then (ωh)²/24 = 1e-3, and a journal crosses its clearance many times within a
/// step. Empty for shorter steps.
inline std::string long_step(const Scene& scene) {
  const auto* drive = main_drive(scene.mechanism);
  const auto& o = scene.nonsmooth;
  if (!drive || !o.step || o.scheme_in_force() != Scheme::moreau_jean) return {};
  const double turned = std::abs(drive->speed) * *o.step * 180 / std::numbers::pi;
  if (!(turned > 10)) return {};
  return fmt::format(
      "nonsmooth.step = {:.4g} s is {:.3g} deg of rotation of drives.{}: too long to resolve contacts",
      *o.step, turned, drive->name);
}

/// Reason why the main drive cannot rotate fully.
inline std::string describe(const Scene& scene, const DeadPoint& dead) {
  return fmt::format(
      "drives.{} cannot make a full turn: after {:.4g} deg, at {:.4g} s, the loop with {} cannot close "
      "without clearance; is a link too short",
      main_drive(scene.mechanism)->name, dead.angle * 180 / std::numbers::pi, dead.t,
      key_of(scene.mechanism, dead.open));
}

/// Prints all questions and notes about a scene. `ideal` receives the start of the ideal mechanism if it was
/// needed.
inline void ask(const Scene& scene, std::optional<IdealStart>* ideal = nullptr) {
  auto all = plausibility_checks(scene.mechanism);
  if (const auto dead = dead_point(scene.mechanism, scene.run.duration, ideal))
    all.push_back(describe(scene, *dead) + "?");
  if (const auto step = long_step(scene); !step.empty()) all.push_back(step + "?");
  for (const auto& q : all) fmt::print(stderr, "{}", wrapped("question: " + q + "\n", 10));
  for (const auto& key : scene.idle) fmt::print(stderr, "{}", wrapped("note: " + key + "\n", 6));
}

// The result of an assembly as text, for `freeplay check`.

/// Rows of a table, name and text: mobility (3n − rank G, with and without drives) and undriven
/// motions, four-bar loops with Grashof's condition and branch, the turn of the drive
/// (dynamics/assembly/turn_survey.hpp), the angles that [assembly] names, the play of joints, the teeth of
/// gears, losses of teeth, controllers, freewheels, and the pose; first the initial values that the start
/// corrected, if they are many.
std::vector<std::pair<std::string, std::string>> assembly_report(const Scene& scene, const State& start);

}  // namespace freeplay::cli
