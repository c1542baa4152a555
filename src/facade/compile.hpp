// Compiled functions for the System of a simulation: when they are made, and what became of them.
//
// Compilation costs tenths of a second to seconds, and a compiled right-hand side saves a few
// microseconds. A run of unknown work therefore compiles once it has evaluated as many right-hand
// sides as a compilation costs: at worst the whole costs twice the better choice. The compiled
// functions give the digits of the general ones, which is checked before they are used, so the
// instant of the change has no effect on results.
#pragma once

#include <memory>
#include <mutex>
#include <utility>
#include <vector>

#include "dynamics/lane_functions.hpp"
#include "dynamics/system.hpp"
#include "dynamics/system_functions.hpp"
#include "facade/simulation.hpp"
#include "numerics/saddle_point.hpp"
#include "values/result.hpp"

namespace freeplay {

/// Right-hand sides after which a run compiles its mechanism.
inline constexpr long compiles_after = 100'000;

/// The choice in force: `asked`, or if that is automatic the environment variable FREEPLAY_COMPILE.
/// Throws ModelError if its value is no such word.
Compile compile_choice(Compile asked);

/// Functions of steps in lanes that have been compiled and checked.
struct LaneStructure {
  TracedLanes traced;  ///< of the first system
  LaneFunctions functions;
};
/// Holds a LaneStructure, once it is made. Safe for concurrent use.
class LaneShelf {
 public:
  std::shared_ptr<const LaneStructure> get() const {
    const std::lock_guard lock(mutex_);
    return made_;
  }
  void set(std::shared_ptr<const LaneStructure> made) {
    const std::lock_guard lock(mutex_);
    made_ = std::move(made);
  }

 private:
  mutable std::mutex mutex_;
  std::shared_ptr<const LaneStructure> made_;
};

/// A traced System and its compiled object, which others of the same structure may use.
struct CompiledStructure {
  TracedSystem traced;
  std::shared_ptr<const void> library;
  const CompiledFunction* table = nullptr;
  std::shared_ptr<LaneShelf> lanes = std::make_shared<LaneShelf>();
};
/// Traces, compiles and checks a System near a state, and attaches the functions. Returns what became
/// of it; `from` is left to the caller.
/// `steps`: also whole time steps of fixed length. `structure`: another one or null, and on return
/// that of this System; with an equal one nothing is compiled, and the check has one state only, or
/// none if the constants are equal, too.
CompiledRun compile_system(System& system, const State& near, RowFacts facts, StopToken stop,
                           bool steps = false, std::shared_ptr<const CompiledStructure>* structure = nullptr);

/// A system that may run in lanes, with its compiled functions attached.
struct LaneCandidate {
  const System* system;
  const State* near;
  RowFacts facts;
};
/// Functions of steps in lanes for systems of one structure.
struct CompiledLanes {
  LaneFunctions functions;         ///< lanes = 0: there are none
  std::vector<TracedLanes> lanes;  ///< of each candidate
  /// Whether each candidate has a lane: it has the structure of the first one.
  std::vector<bool> fits;
};
/// Traces all candidates, and compiles and checks the functions of those with the structure of the
/// first one. `shelf`: where these functions are kept, or null; if they are there already, nothing is
/// compiled, and the check has one state only.
CompiledLanes compile_lanes(const std::vector<LaneCandidate>& candidates, StopToken stop,
                            LaneShelf* shelf = nullptr);

}  // namespace freeplay
