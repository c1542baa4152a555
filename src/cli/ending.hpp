// What is said of a run when it is over.
#pragma once

#include "values/result.hpp"

namespace freeplay::cli {

/// Which reactions mechanics leaves open.
void say_undetermined(const Result& result);

/// 0 for a finished run; else says on stderr why it ended.
int report(const Result& result);

}  // namespace freeplay::cli
