// Contents of hostile files: texts that some program might execute or interpret. Runs the program
// on them with its arguments unchanged, without a shell.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

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

struct Told {
  int status;  ///< as in a shell: 128 + signal; −1 after a minute
  std::string out, err;
  /// Exit status 0, 1 or 2, and no control character except line ends and tabs.
  bool decent() const;
};

/// Runs the program in the bait's folder.
Told run_program(const Bait& bait, const std::vector<std::string>& arguments);

/// A text as TOML's basic string.
std::string in_toml(const std::string& text);

/// A scene with a run of some milliseconds: the paper's rig, with this title.
std::string rig(const std::string& title_in_quotes);

}  // namespace freeplay::test
