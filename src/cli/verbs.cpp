// Verbs of the program freeplay.
#include "cli/command_line.hpp"

void freeplay::cli::declare_verbs(Program& program) {
#define VERB(name) \
  if (program.declares(#name)) name##_verb(program);
#define VERIFICATION_VERB(name, what) \
  if (program.declares(#name)) program.second_program_verb(#name, what);
#include "cli/verbs.def"
}
