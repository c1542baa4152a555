// Interface of impact laws (impact.hpp); each law has its own file. A law gets an island with D and
// the rates before the impact, sets the impulses of its contacts and adds their works to the
// island. It returns false if no impulses satisfy it. To add a law: its enumerator and row
// (ImpactLaw) in src/mechanism/options.hpp, its file, its function here and its case below.
#pragma once

#include <vector>

#include "formulations/contact/impact_island.hpp"
#include "formulations/contact/impact_phases.hpp"

namespace freeplay {

using ImpactContacts = std::vector<ImpactContact>;

/// `phases`: work space for laws that integrate an impact through its phases.
bool newton_impact(ImpactIsland& island, ImpactPhases& phases, ImpactContacts& contacts);
bool poisson_impact(ImpactIsland& island, ImpactPhases& phases, ImpactContacts& contacts);
bool energetic_impact(ImpactIsland& island, ImpactPhases& phases, ImpactContacts& contacts);
bool compliant_impact(ImpactIsland& island, ImpactPhases& phases, ImpactContacts& contacts);

inline bool impact_by(ImpactLaw law, ImpactIsland& island, ImpactPhases& phases, ImpactContacts& contacts) {
  switch (law) {
    case ImpactLaw::newton:
      return newton_impact(island, phases, contacts);
    case ImpactLaw::poisson:
      return poisson_impact(island, phases, contacts);
    case ImpactLaw::energetic:
      return energetic_impact(island, phases, contacts);
    case ImpactLaw::compliant:
      return compliant_impact(island, phases, contacts);
  }
  return false;
}

}  // namespace freeplay
