#include "cli/ending.hpp"

#include <fmt/format.h>

#include "cli/wrapped.hpp"

namespace freeplay::cli {

void say_undetermined(const Result& result) {
  if (result.undetermined.empty()) return;
  fmt::print("{}", wrapped(fmt::format("note: the reactions of {} are statically indeterminate (dependent "
                                       "constraint rows); forces.csv has the minimum-norm solution\n",
                                       fmt::join(result.undetermined, ", "))));
}

int report(const Result& result) {
  if (result.ending.status == Ending::Status::finished) return 0;
  if (result.ending.status == Ending::Status::failed)
    fmt::print(stderr, "{}: stopped: {}\n", result.formulation, result.ending.reason);
  else
    fmt::print(stderr, "interrupted: {} at t = {:.9g} s\n", result.formulation, result.t_end);
  return 1;
}

int interrupted(Kept kept) {
  fmt::print(stderr, "interrupted; the same command {}\n",
             kept == Kept::runs ? "continues" : "starts again, nothing was written");
  return 1;
}

}  // namespace freeplay::cli
