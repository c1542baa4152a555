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

CompiledRun compile_system(System& system, const State& near, RowFacts facts, StopToken stop, bool steps) {
  CompiledRun found;
  const auto traced = trace_system(system, near, facts, steps);
  found.general_parts = traced.untraced;
  if (traced.object.functions() == 0) {
    found.reason = "no part of the mechanism can be compiled";
    return found;
  }
  const auto object = compiled_object(traced.object.text(), traced.object.functions(), stop);
  if (!object.library) {
    found.reason = object.reason;
    return found;
  }
  auto functions = traced.functions(object.table);
  functions.object = object.library;
  if (differing_quantities(system, functions, near, facts) > 0 ||
      (functions.step.middle && differing_steps(system, functions, near, facts) > 0)) {
    found.reason = "the compiled functions give other digits, as with a program built for fused multiply-add";
    return found;
  }
  system.attach(std::move(functions));
  found.used = true;
  return found;
}

CompiledLanes compile_lanes(const std::vector<LaneCandidate>& candidates, StopToken stop) {
  CompiledLanes found;
  std::string text;
  std::vector<LaneCheck> checks;
  for (const auto& candidate : candidates) {
    found.lanes.push_back(
        trace_lanes(*candidate.system, *candidate.near, candidate.facts, lanes_of_machine()));
    const auto& lanes = found.lanes.back();
    const auto own = lanes.traced ? lanes.object.text() : std::string();
    if (found.lanes.size() == 1) text = own;
    found.fits.push_back(lanes.traced && own == text);
  }
  for (std::size_t i = 0; i < candidates.size(); ++i)
    if (found.fits[i] && checks.size() < static_cast<std::size_t>(lanes_of_machine()))
      checks.push_back({candidates[i].system, candidates[i].near, &found.lanes[i].object.constants()});
  if (checks.size() < 2) return found;
  const auto object = compiled_object(text, found.lanes.front().object.functions(), stop);
  if (!object.library) return found;
  auto functions = found.lanes.front().functions(object.table);
  functions.object = object.library;
  if (differing_lanes(functions, checks, candidates.front().facts) == 0)
    found.functions = std::move(functions);
  return found;
}

}  // namespace freeplay
