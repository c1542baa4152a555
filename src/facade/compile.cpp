#include "facade/compile.hpp"

#include <fmt/format.h>

#include <cstdlib>
#include <string_view>

#include "dynamics/system_functions.hpp"
#include "formulations/time_stepping/step_check.hpp"
#include "io/files/compiled_object.hpp"
#include "mechanism/error.hpp"

namespace freeplay {

Compile compile_choice(Compile asked) {
  const char* named = std::getenv("FREEPLAY_COMPILE");
  if (asked != Compile::automatic || !named || !*named) return asked;
  for (const auto& [word, choice] : compile_words)
    if (word == named) return choice;
  throw ModelError("FREEPLAY_COMPILE",
                   fmt::format("must be \"automatic\", \"always\" or \"never\", is \"{}\"", named));
}

CompiledRun compile_system(System& system, const State& near, RowFacts facts, StopToken stop, bool steps,
                           std::shared_ptr<const CompiledStructure>* structure) {
  CompiledRun found;
  auto mine = structure ? std::move(*structure) : nullptr;
  auto traced = trace_system(system, near, facts, steps, mine ? &mine->traced : nullptr);
  found.general_parts = traced.untraced;
  const bool known =
      mine && mine->traced.object.same_structure(traced.object) && mine->traced.steps == traced.steps;
  if (traced.object.functions() == 0) {
    found.reason = "no part of the mechanism can be compiled";
    return found;
  }
  if (!known) {
    auto object = compiled_object(traced.object.text(), traced.object.functions(), stop);
    if (!object.library) {
      found.reason = object.reason;
      return found;
    }
    mine = std::make_shared<const CompiledStructure>(
        CompiledStructure{.traced = traced, .library = std::move(object.library), .table = object.table});
  }
  auto functions = traced.functions(mine->table);
  functions.object = mine->library;
  const bool same = known && mine->traced.object.constants() == traced.object.constants();
  const int states = same ? 0 : known ? 1 : states_compared;
  if (differing_quantities(system, functions, near, facts, states) > 0 ||
      (functions.step.middle && differing_steps(system, functions, near, facts, states) > 0)) {
    found.reason = "the compiled functions give other digits, as with a program built for fused multiply-add";
    return found;
  }
  system.attach(std::move(functions));
  if (structure) *structure = std::move(mine);
  found.used = true;
  return found;
}

CompiledLanes compile_lanes(const std::vector<LaneCandidate>& candidates, StopToken stop, LaneShelf* shelf) {
  CompiledLanes found;
  const int width = lanes_of_machine();
  auto known = shelf ? shelf->get() : nullptr;
  std::vector<LaneCheck> checks;
  found.lanes.reserve(candidates.size());
  for (const auto& candidate : candidates) {
    const auto* like = known ? &known->traced : found.lanes.empty() ? nullptr : &found.lanes.front();
    const auto& lanes = found.lanes.emplace_back(
        trace_lanes(*candidate.system, *candidate.near, candidate.facts, width, like));
    if (known && found.lanes.size() == 1 && !lanes.object.same_structure(known->traced.object))
      known = nullptr;
    const bool fits = lanes.traced && lanes.object.same_structure(found.lanes.front().object);
    found.fits.push_back(fits);
    if (fits && checks.size() < static_cast<std::size_t>(width))
      checks.push_back({candidate.system, candidate.near, &lanes.object.constants()});
  }
  if (checks.size() < 2) return found;
  if (known) {
    if (differing_lanes(known->functions, checks, candidates.front().facts, 1) == 0)
      found.functions = known->functions;
    return found;
  }
  const auto& first = found.lanes.front();
  const auto object = compiled_object(first.object.text(), first.object.functions(), stop);
  if (!object.library) return found;
  auto functions = first.functions(object.table);
  functions.object = object.library;
  if (differing_lanes(functions, checks, candidates.front().facts) > 0) return found;
  if (shelf) shelf->set(std::make_shared<const LaneStructure>(LaneStructure{first, functions}));
  found.functions = std::move(functions);
  return found;
}

}  // namespace freeplay
