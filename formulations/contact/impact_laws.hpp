// Impact laws (impact.hpp), each in a file of its own and all called alike: a law gets an island with D and the rates before, leaves
// the impulses of its contacts and adds their works. False where no impulses keep it. To add one: its name in
// mechanism/options.hpp, a function here with its file, and a case below.
#pragma once

#include <vector>

#include "formulations/contact/impact_island.hpp"
#include "formulations/contact/impact_phases.hpp"

namespace freeplay {

using ImpactContacts = std::vector<ImpactContact>;

/// `phases`: room for the laws that follow an impact through its phases.
bool newton_impact(ImpactIsland& island, ImpactPhases& phases, ImpactContacts& contacts);
bool poisson_impact(ImpactIsland& island, ImpactPhases& phases, ImpactContacts& contacts);
bool energetic_impact(ImpactIsland& island, ImpactPhases& phases, ImpactContacts& contacts);

inline bool impact_by(ImpactLaw law, ImpactIsland& island, ImpactPhases& phases, ImpactContacts& contacts) {
  switch (law) {
    case ImpactLaw::newton:
      return newton_impact(island, phases, contacts);
    case ImpactLaw::poisson:
      return poisson_impact(island, phases, contacts);
    case ImpactLaw::energetic:
      return energetic_impact(island, phases, contacts);
  }
  return false;
}

}  // namespace freeplay
