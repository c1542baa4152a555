// Poisson's law, P_N = e P_C + extra, extra ≥ 0 ⊥ u_N⁺ ≥ 0 in expansion: the expansion impulse of
// each contact is e times its compression impulse, plus an extra impulse where the contact would
// close otherwise.
#include "formulations/contact/impact_laws.hpp"

namespace freeplay {

bool poisson_impact(ImpactIsland& island, ImpactPhases& phases, ImpactContacts& contacts) {
  if (contacts.size() == 1) return routh_impact(ImpactLaw::poisson, island, contacts.front());
  std::vector<double> ratio;
  for (const auto& c : contacts) ratio.push_back(c.restitution);
  if (!phases.compress(island, contacts) || !phases.expand(island, contacts, ratio)) return false;
  phases.add_works(island);
  return true;
}

}  // namespace freeplay
