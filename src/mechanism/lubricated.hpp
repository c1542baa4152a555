// Whether a lubricant film carries a joint while its contact is open.
#pragma once

#include <algorithm>
#include <string>
#include <variant>

#include "mechanism/mechanism.hpp"

namespace freeplay {

inline bool lubricated(const Mechanism& mechanism, const std::string& joint) {
  return std::ranges::any_of(mechanism.joints, [&](const Joint& j) {
    const auto* pin = std::get_if<RevoluteJoint>(&j);
    return pin && pin->name == joint && pin->clearance && pin->clearance->lubricant >= 0;
  });
}

}  // namespace freeplay
