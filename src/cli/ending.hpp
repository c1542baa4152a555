// What is said of a run when it is over.
#pragma once

#include "values/result.hpp"

namespace freeplay::cli {

/// Which reactions mechanics leaves open.
void say_undetermined(const Result& result);

/// 0 for a finished run; else says on stderr why it ended.
int report(const Result& result);

/// What a verb leaves that was stopped: the runs that it has stored, or nothing.
enum class Kept { runs, nothing };

/// Says on stderr that the user stopped it, and what the same command does then. The status, 1.
int interrupted(Kept kept);

}  // namespace freeplay::cli
