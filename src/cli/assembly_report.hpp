// The result of an assembly as text, for `freeplay check`.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "values/state.hpp"

namespace freeplay {
struct Mechanism;
}

namespace freeplay::cli {

/// Rows of a table, name and text: mobility (3n − rank G, with and without drives) and undriven
/// motions, four-bar loops with Grashof's condition and branch, the turn of the drive
/// (dynamics/assembly/turn_survey.hpp), the angles that [assembly] names, the teeth of gears, and the pose.
std::vector<std::pair<std::string, std::string>> assembly_report(const Mechanism& mechanism,
                                                                 const State& start);

}  // namespace freeplay::cli
