// What a run is: all that its digits depend on, as text. Two runs of equal identity have equal digits. It is
// derived from what ran, never typed, and is the only source of run.json's provenance, of a study's keys, of
// what a checkpoint may be resumed by, and of what `freeplay run --from` repeats.
#pragma once

#include <string>

namespace freeplay {

/// Four parts of lines KEY = VALUE, in TOML. Comments, blank lines and the spelling of a scene do not count; nor
/// does the commit.
struct Identity {
  std::string scene;        ///< canonical text of the scene as it ran: every fact, every option in force
  std::string formulation;  ///< which, and the restitution that its contacts took from the penalty law
  std::string given;        ///< what the caller gave beside the scene: a start; of a study's run its settings
  std::string program;      ///< sources, compiler, flags, instruction set, libraries

  bool operator==(const Identity&) const = default;
  /// 32 hexadecimal digits over all parts.
  std::string digest() const;
};

}  // namespace freeplay
