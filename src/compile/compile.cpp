#include "compile/compile.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <string_view>

#include "dynamics/motion_kernel.hpp"
#include "dynamics/system_functions.hpp"
#include "formulations/time_stepping/lanes.hpp"
#include "mechanism/error.hpp"

namespace freeplay {
namespace {

/// Number of recorded operations; some of them are not needed by any result.
double operations_of(const TracedObject& object) {
  double sum = 0;
  for (int i = 0; i < object.functions(); ++i) sum += static_cast<double>(object.function(i).nodes.size());
  return sum;
}

/// The object of a trace, from the cache, or compiled if that takes at most `worth` (s).
CompiledObject object_worth(const TracedObject& traced, double worth, const StopToken& stop) {
  const double estimate = compile_seconds(traced);
  const bool too_long = estimate > worth;
  CompiledObject object;
  if (estimate <= longest_estimate)
    object = compiled_object(traced.text(), traced.functions(), stop, !too_long);
  if (!object.library && too_long)
    object.reason =
        fmt::format("a compilation of {:.2g} operations takes about {:.2g} s, more than {}",
                    operations_of(traced), estimate,
                    worth < longest_estimate
                        ? fmt::format("the rest of the run can save ({:.2g} s)", worth)
                        : fmt::format("half the time limit of the compiler ({} s)", longest_compilation));
  return object;
}

}  // namespace

double compile_seconds(const TracedObject& object) { return 0.1 + 3e-4 * operations_of(object); }

Compile compile_choice(Compile asked) {
  const char* named = std::getenv("FREEPLAY_COMPILE");
  if (asked != Compile::automatic || !named || !*named) return asked;
  for (const auto& [word, choice] : compile_words)
    if (word == named) return choice;
  throw ModelError("FREEPLAY_COMPILE",
                   fmt::format("must be \"automatic\", \"always\" or \"never\", is \"{}\"", named));
}

bool CompiledStructures::any() const {
  const std::lock_guard lock(mutex_);
  return !all_.empty();
}

std::shared_ptr<const CompiledStructure> CompiledStructures::latest() const {
  const std::lock_guard lock(mutex_);
  return latest_;
}

std::shared_ptr<const CompiledStructure> CompiledStructures::find(const TracedSystem& traced) {
  const std::lock_guard lock(mutex_);
  for (const auto& one : all_)
    if (one->traced.same_structure(traced)) return latest_ = one;
  return nullptr;
}

void CompiledStructures::add(std::shared_ptr<const CompiledStructure> structure) {
  const std::lock_guard lock(mutex_);
  latest_ = structure;
  all_.push_back(std::move(structure));
}

std::optional<CompiledRun> compile_system(System& system, const State& near, RowFacts facts, StopToken stop,
                                          TracedFor scheme, CompiledStructures* structures, bool only_known,
                                          double worth) {
  CompiledRun found;
  const auto like = structures ? structures->latest() : nullptr;
  auto traced = trace_system(system, near, facts, scheme, like ? &like->traced : nullptr);
  found.general_parts = traced.untraced;
  if (traced.object.functions() == 0) {
    found.reason = "no part of the mechanism can be compiled";
    return found;
  }
  if (scheme == TracedFor::fixed_steps && traced.solves && traced.untraced.empty())
    traced.steps = trace_steps(traced.object, system, near, facts);
  auto structure = structures ? structures->find(traced) : nullptr;
  const bool known = structure != nullptr;
  if (!known && only_known) return {};
  if (!known) {
    auto object = object_worth(traced.object, std::min(worth, longest_estimate), stop);
    structure = std::make_shared<const CompiledStructure>(
        CompiledStructure{traced, std::move(object.library), object.table, std::move(object.reason)});
  }
  if (!structure->library) {
    found.reason = structure->reason;
    if (structures && !known) structures->add(std::move(structure));
    return found;
  }
  auto functions = traced.functions(structure->table);
  functions.object = structure->library;
  const bool same = known && structure->traced.object.constants() == traced.object.constants();
  const int states = same ? 0 : known ? 1 : states_compared;
  if (differing_quantities(system, functions, near, facts, states) > 0 ||
      differing_motions(system, functions, near, facts, states) > 0 ||
      (!functions.steps.empty() && differing_steps(system, functions, near, facts, states) > 0)) {
    found.reason =
        "the compiled functions are not bitwise identical to the general ones, as with a program built for "
        "fused multiply-add";
    return found;
  }
  system.compiled().attach(std::move(functions));
  if (structures && !known) structures->add(std::move(structure));
  found.used = true;
  return found;
}

std::optional<LaneFunctions> compile_lanes(const std::vector<LaneCandidate>& candidates, StopToken stop) {
  std::vector<LaneCheck> checks;
  for (const auto& one : candidates)
    checks.push_back({one.system, one.near, &one.traced->object.constants()});
  if (checks.size() < 2) return {};
  const auto& first = *candidates.front().traced;
  const auto object = object_worth(first.object, longest_estimate, stop);
  if (!object.library) return {};
  auto functions = first.compiled(object.table);
  functions.object = object.library;
  if (differing_lanes(functions, checks, candidates.front().facts) > 0) return {};
  return functions;
}

}  // namespace freeplay
