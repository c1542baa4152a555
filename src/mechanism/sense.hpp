// Numbers that are possible but make no sense in the units of a scene (SI): degrees for radians, GPa for Pa, mm for m.
// A scene that means them is run all the same: they are questions, not errors.
#pragma once

#include <string>
#include <vector>

namespace freeplay {

struct Mechanism;

/// What its author should be asked, each with the likely meaning; at most one for each rule of sense.cpp, which names
/// the first element and counts the others. Empty for a mechanism in order.
std::vector<std::string> questions(const Mechanism& mechanism);

}  // namespace freeplay
