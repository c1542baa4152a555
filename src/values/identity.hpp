// Identity of a run: everything that determines its bits, as text. Two runs with equal identity are
// bitwise identical. The identity is derived from the objects that ran, never typed. It is the only
// source of run.json's provenance, of the keys of a study, of the check whether a checkpoint can be
// resumed, and of the run that `freeplay run --from` repeats.
#pragma once

#include <string>

namespace freeplay {

/// Four parts of lines KEY = VALUE, in TOML. Comments, blank lines and the spelling of a scene do
/// not count; neither does the commit.
struct Identity {
  std::string scene;  ///< canonical text of the scene as run: every fact and every current option
  /// Its name, and the restitutions that its contacts took from the penalty law.
  std::string formulation;
  std::string given;    ///< input besides the scene: a start; for a run of a study, its settings
  std::string program;  ///< sources, compiler, flags, instruction set, libraries

  /// Whether all parts are equal.
  bool operator==(const Identity&) const = default;
  /// 32 hexadecimal digits over all parts.
  std::string digest() const;
};

}  // namespace freeplay
