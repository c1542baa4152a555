// Contents of hostile files: texts that some program might execute or interpret. Runs the program
// on them with its arguments unchanged, without a shell.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace freeplay::test {

/// A folder to work in, the file that must not appear whatever is read there, and one that must stay as it is.
struct Bait {
  explicit Bait(const std::filesystem::path& place);
  std::filesystem::path folder, canary, victim;
  /// That nothing was executed and nothing overwritten.
  bool untouched() const;
};

/// Texts that touch the canary where they are obeyed, and others that no terminal, path or reader likes.
std::vector<std::string> hostile_texts(const Bait& bait);

struct Told {
  int status;  ///< as a shell has it: 128 + signal; −1 after a minute
  std::string out, err;
  /// Exit status 0, 1 or 2, and no control character but line ends and tabs.
  bool decent() const;
};

/// Runs the program in the bait's folder.
Told run_program(const Bait& bait, const std::vector<std::string>& arguments);

/// A text as TOML's basic string.
std::string in_toml(const std::string& text);

/// A scene of some milliseconds: the paper's rig, with this title.
std::string rig(const std::string& title_in_quotes);

}  // namespace freeplay::test
