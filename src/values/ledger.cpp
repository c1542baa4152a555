#include "values/ledger.hpp"

#include <algorithm>
#include <cmath>

namespace freeplay {

double EnergyLedger::scale() const {
  return std::max({std::abs(kinetic), std::abs(initial), std::abs(drive), std::abs(load), std::abs(contact),
                   std::abs(friction), std::abs(damping), std::abs(kinetic + potential + elastic - initial)});
}

}  // namespace freeplay
