// Compiled functions for the System of a simulation: when they are made, and what became of them.
//
// Compilation costs tenths of a second to seconds, and a compiled right-hand side saves a few
// microseconds. A run compiles once the time that it has taken so far shows that its rest will save more. A
// study, whose work is unknown, compiles once a run has evaluated as many right-hand
// sides as a compilation costs: at worst the whole costs twice the better choice. The compiled
// functions are bitwise identical to the general ones, which is checked before they are used, so the
// instant of the change has no effect on results.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "compile/compiled_object.hpp"
#include "compile/compiled_structures.hpp"
#include "dynamics/system.hpp"
#include "dynamics/system_functions.hpp"
#include "formulations/time_stepping/lane_functions.hpp"
#include "numerics/saddle_point.hpp"
#include "values/compile.hpp"
#include "values/result.hpp"

namespace freeplay {

/// Right-hand sides after which a run of its own compiles its mechanism, if its rest is estimated to save
/// more than that costs.
inline constexpr long compiles_after = 20'000;
/// The same for the first run of a study, whose other runs cannot be estimated: as many as a compilation
/// costs.
inline constexpr long compiles_study_after = 100'000;
/// The same where the compiled functions of its structure are known already: tracing and the check cost
/// about as much as so many right-hand sides.
inline constexpr long attaches_after = 2'000;
/// Greatest share of its time that a run saves by compiled functions: steps of one lane take 2,080
/// instructions instead of 8,220 (docs/theory/compiled.md).
inline constexpr double most_saved = 0.75;
/// Time (s) that `cc` needs for the functions of an object: 0.1 s, and 0.3 ms for each operation. Mechanisms
/// of 1 to 128 bodies with 240 to 167,000 operations took 0.15 to 0.55 ms for each on a busy machine, and
/// half of that on an idle one (GCC 12).
double compile_seconds(const TracedObject& object);
/// Estimates above it are refused: on a busy machine the compilation would reach its time limit.
inline constexpr double longest_estimate = 0.5 * longest_compilation;

/// The choice in force: `asked`, or if that is automatic the environment variable FREEPLAY_COMPILE.
/// Throws ModelError if its value is no such word.
Compile compile_choice(Compile asked);

/// A traced System and its compiled object, which others of the same structure may use. Without a
/// library: why it cannot be compiled.
struct CompiledStructure {
  TracedSystem traced;
  std::shared_ptr<const void> library = {};
  const CompiledFunction* table = nullptr;
  std::string reason = {};
};
/// Traces, compiles and checks a System near a state, and attaches the functions. Returns what became
/// of it; `from` is left to the caller. Nothing if `only_known` is set and `structures` do not have it.
/// `scheme`: of the run. `structures`: known ones, to which it is added, or
/// null; of a known one nothing is compiled, and the check has one state only, or none if its constants
/// are equal, too. What cannot be compiled is known, too. `worth`: s, time that a compilation may take.
std::optional<CompiledRun> compile_system(System& system, const State& near, RowFacts facts, StopToken stop,
                                          TracedFor scheme = TracedFor::any,
                                          CompiledStructures* structures = nullptr, bool only_known = false,
                                          double worth = longest_estimate);

/// A system that may run in lanes, with its compiled functions attached.
struct LaneCandidate {
  const System* system;
  const State* near;
  RowFacts facts;
  const TracedLanes* traced;  ///< trace_lanes() of it
};
/// Compiles and checks the functions of steps in lanes for systems of one structure, of which there are
/// at least two. Without result if they cannot be compiled.
std::optional<LaneFunctions> compile_lanes(const std::vector<LaneCandidate>& candidates, StopToken stop);

}  // namespace freeplay
