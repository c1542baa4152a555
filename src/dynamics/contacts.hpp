// The contacts that a mechanism has, for those who need no System.
#pragma once

#include <string>
#include <vector>

namespace freeplay {

struct Mechanism;

/// Their names, those of loose joints among them, in the order of ContactEvent::contact.
std::vector<std::string> contact_names(const Mechanism& mechanism);

}  // namespace freeplay
