#include "cli/ending.hpp"

#include <fmt/format.h>

#include "cli/wrapped.hpp"

namespace freeplay::cli {

void say_undetermined(const Result& result) {
  if (result.undetermined.empty()) return;
  fmt::print(
      "{}", wrapped(fmt::format("note: mechanics does not determine the reactions of {} (rows depend on each "
                                "other): those in forces.csv are of least norm\n",
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
             kept == Kept::runs ? "carries on" : "begins anew, nothing is written");
  return 1;
}

}  // namespace freeplay::cli
