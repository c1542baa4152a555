// Help, for a terminal of 80 columns: what the program and each verb says of itself. The options come from where they are
// declared (src/cli/NAME.cpp), what a verb does and leaves behind, with examples, from src/cli/help/NAME.txt. docs/reference/verbs.md
// is made of the same pages (scripts/pages).
#pragma once

#include <string>
#include <vector>

namespace freeplay::cli {

/// An option as its verb declares it.
struct OptionHelp {
  std::string names;  ///< "-o,--output", or a positional's
  std::string takes;  ///< FOLDER, or "a|b"; "" for a flag
  std::string what;
  bool positional = false;
  bool required = false;
  bool many = false;  ///< more than one value
};

struct VerbHelp {
  std::string name, what;
  std::vector<OptionHelp> options;
};

struct ProgramHelp {
  std::string what;
  std::vector<VerbHelp> verbs;
};

std::string overview_page(const ProgramHelp& program);
std::string verb_page(const VerbHelp& verb);

}  // namespace freeplay::cli
