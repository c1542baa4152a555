// Newton's law, u_N⁺ ≥ −e u_N⁻ ⊥ P_N ≥ 0, −P_T ∈ μ P_N Sgn(u_T⁺ + e_T u_T⁻): a single contact
// problem.
#include "formulations/contact/impact_laws.hpp"

namespace freeplay {

bool newton_impact(ImpactIsland& island, ImpactPhases&, ImpactContacts& contacts) {
  auto& problem = island.problem;
  const auto& before = island.before;
  const int m = problem.rows;
  island.pose(contacts);
  problem.b.head(m) = before.head(m);
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    auto& x = problem.unknowns[i];
    const auto& c = contacts[i];
    if (c.normal < 0 || before[c.normal] >= 0) continue;
    x.target_n = -c.restitution * before[c.normal];
    if (c.tangent >= 0) x.target_t = -c.tangential_restitution * before[c.tangent];
  }
  if (!island.solve()) return false;
  island.after = before;
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    contacts[i].impulse_n = problem.unknowns[i].impulse_n;
    contacts[i].impulse_t = problem.unknowns[i].impulse_t;
    island.act(island.after, contacts[i]);
  }
  island.add_works_at_once(contacts);
  return true;
}

}  // namespace freeplay
