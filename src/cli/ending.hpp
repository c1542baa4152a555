// Messages about the end of a run.
#pragma once

#include "values/result.hpp"

namespace freeplay::cli {

/// Prints the reactions that mechanics does not determine.
void say_undetermined(const Result& result);

/// Exit status of a run: 0 if it finished; otherwise prints the reason to stderr.
int report(const Result& result);

/// What remains of an interrupted verb: the stored runs, or nothing.
enum class Kept { runs, nothing };

/// Prints to stderr that the user interrupted the verb, and what the same command does next.
/// Returns the exit status, 1.
int interrupted(Kept kept);

}  // namespace freeplay::cli
