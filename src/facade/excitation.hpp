// Explicit dependence of a mechanism on time, and its period: one turn of a drive with constant speed, or
// the period of a curve against time.
#pragma once

#include <optional>
#include <string>

namespace freeplay {

struct Mechanism;
class System;

/// Period of the explicit dependence on time.
struct Excitation {
  bool any = false;   ///< whether the equations depend on time
  double period = 0;  ///< s; 0: none found
  std::string why;    ///< reason why none was found
};

/// Of several periods, it is the longest one if the others are its divisors.
Excitation excitation_of(const Mechanism& mechanism, const System& system);

/// The period of the section (s): that of the excitation, else the given one. Throws ModelError if neither is
/// known or both differ.
double section_period(const Excitation& excitation, const std::optional<double>& given);

}  // namespace freeplay
