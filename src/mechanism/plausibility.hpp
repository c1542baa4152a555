// Plausibility check of units. It finds numbers that are valid but unlikely in SI units: degrees in
// place of rad, GPa in place of Pa, mm in place of m. The scene runs all the same: the results are
// questions to its author, not errors.
#pragma once

#include <string>
#include <vector>

namespace freeplay {

struct Mechanism;

/// One question for each rule of plausibility.cpp that finds something, with the likely intended value. A
/// question names the first element found and counts the others. Empty if nothing is implausible.
std::vector<std::string> plausibility_checks(const Mechanism& mechanism);

}  // namespace freeplay
