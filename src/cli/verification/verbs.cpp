// Verbs of the program freeplay-verify, which contains the claims.
#include "cli/command_line.hpp"

void freeplay::cli::declare_verbs(Program& program) {
#define VERB(name)
#define VERIFICATION_VERB(name, what) \
  if (program.declares(#name)) name##_verb(program);
#include "cli/verbs.def"
}
