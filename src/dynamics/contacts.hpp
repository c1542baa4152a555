// Names of a mechanism's contacts, for code that needs no System.
#pragma once

#include <string>
#include <vector>

namespace freeplay {

struct Mechanism;

/// The names, including those of joints with clearance, in the order of ContactEvent::contact.
std::vector<std::string> contact_names(const Mechanism& mechanism);

}  // namespace freeplay
