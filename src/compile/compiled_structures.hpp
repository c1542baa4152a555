// CompiledStructures: the compiled functions that the runs of a study share. Scenes that differ in
// parameters only have one structure and one compilation (docs/theory/compiled.md).
#pragma once

#include <memory>
#include <mutex>
#include <vector>

namespace freeplay {

struct CompiledStructure;
struct TracedSystem;

/// Compiled functions of several structures. Simulations that refer to one object
/// (SimulationOptions::structures) compile each structure once, and compile early if theirs is known.
/// Safe for concurrent use.
class CompiledStructures {
 public:
  /// Whether there are any.
  bool any() const;
  /// The one that was added or found last; null: there is none.
  std::shared_ptr<const CompiledStructure> latest() const;
  /// Those of a traced mechanism; null: not known.
  std::shared_ptr<const CompiledStructure> find(const TracedSystem& traced);
  /// Adds one.
  void add(std::shared_ptr<const CompiledStructure> structure);

 private:
  mutable std::mutex mutex_;
  std::vector<std::shared_ptr<const CompiledStructure>> all_;
  std::shared_ptr<const CompiledStructure> latest_;
};

}  // namespace freeplay
