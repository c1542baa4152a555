// Contents of hostile files: texts that some program might execute or interpret. Runs the program
// on them with its arguments unchanged.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "verification/support/support.hpp"

namespace freeplay::test {

/// A working folder, a file that must not appear whatever is read, and one that must remain
/// unchanged.
struct Bait {
  explicit Bait(const std::filesystem::path& place);
  std::filesystem::path folder, canary, victim;
  /// Whether nothing was executed and nothing overwritten.
  bool untouched() const;
};

/// Texts that create the canary file if they are executed, and others that are difficult for
/// terminals, paths or readers.
std::vector<std::string> hostile_texts(const Bait& bait);

/// Exit status 0, 1 or 2 (else 128 + signal, or 124 after a minute), and no control character except line
/// ends and tabs.
bool decent(const Outcome& outcome);

/// A working folder with the bait, in which the program runs.
struct Sandbox {
  Sandbox() : bait(folder.path()) {}
  std::filesystem::path at(const std::filesystem::path& name) const { return bait.folder / name; }
  void add(const std::filesystem::path& name, const std::string& text) const;
  /// Runs the program, whose output has to be decent and which has to leave the bait untouched.
  Outcome run(const std::vector<std::string>& words) const;
  Outcome run(const std::string& command) const;
  TemporaryFolder folder;
  Bait bait;

 private:
  Outcome run_program(const std::vector<std::string>& words) const;
};

/// The words of a command, between blanks outside single quotes.
std::vector<std::string> words_of(const std::string& command);

/// A text as TOML's basic string.
std::string in_toml(const std::string& text);

/// A scene with a run of some milliseconds: the paper's rig, with this title.
std::string rig(const std::string& title_in_quotes);

}  // namespace freeplay::test
