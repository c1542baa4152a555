// Help pages of the program and its verbs, for a terminal of 80 columns. The options come from
// their declarations (src/cli/NAME.cpp); the description, the output and the examples of a verb
// come from src/cli/help/NAME.txt. docs/reference/verbs.md contains the same pages (scripts/pages).
#pragma once

#include <string>
#include <vector>

namespace freeplay::cli {

/// An option as its verb declares it.
struct OptionHelp {
  std::string names;  ///< "-o,--output", or the name of a positional argument
  std::string takes;  ///< FOLDER, or "a|b"; "" for a flag
  std::string what;
  bool positional = false;
  bool required = false;
  bool many = false;  ///< takes several values
};

/// A verb and its options.
struct VerbHelp {
  std::string name, what;
  std::vector<OptionHelp> options;
};

/// The program and its verbs.
struct ProgramHelp {
  std::string what;
  std::vector<VerbHelp> verbs;
};

/// The text of `freeplay help`, and of `freeplay help VERB`.
std::string overview_page(const ProgramHelp& program);
std::string verb_page(const VerbHelp& verb);

}  // namespace freeplay::cli
