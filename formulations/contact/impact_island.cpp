#include "formulations/contact/impact_island.hpp"

#include <algorithm>

#include "formulations/contact/routh.hpp"

namespace freeplay {

void ImpactIsland::pose(const std::vector<ImpactContact>& contacts) {
  problem.unknowns.clear();
  for (const auto& c : contacts) {
    ContactUnknown x;
    x.normal = c.normal;
    x.tangent = c.tangent;
    x.friction = c.friction;
    x.bound = c.bound;
    problem.unknowns.push_back(x);
  }
}

void ImpactIsland::act(Eigen::VectorXd& rates, const ImpactContact& by) const {
  const int m = problem.rows;
  if (by.normal >= 0) rates.head(m) += by.impulse_n * problem.D.col(by.normal).head(m);
  if (by.tangent >= 0) rates.head(m) += by.impulse_t * problem.D.col(by.tangent).head(m);
}

void ImpactIsland::add_works_at_once(const std::vector<ImpactContact>& contacts) {
  for (const auto& c : contacts) {
    if (c.normal >= 0) normal_work += 0.5 * c.impulse_n * (before[c.normal] + after[c.normal]);
    if (c.tangent >= 0) tangential_work += 0.5 * c.impulse_t * (before[c.tangent] + after[c.tangent]);
  }
}

bool ImpactIsland::solve() {
  const auto one = problem.solve();
  solution.solved = one.solved;
  solution.residual = std::max(solution.residual, one.residual);
  solution.residual_rate = std::max(solution.residual_rate, one.residual_rate);
  solution.pivots += one.pivots;
  solution.retries += one.retries;
  solution.ambiguous |= one.ambiguous;
  solution.undecided |= one.undecided;
  solution.impossible |= one.impossible;
  return one.solved;
}

bool routh_impact(ImpactLaw law, ImpactIsland& island, ImpactContact& c) {
  const auto& D = island.problem.D;
  const bool rough = c.tangent >= 0;
  const auto impact = routh_impact(law, D(c.normal, c.normal), rough ? D(c.normal, c.tangent) : 0,
                                   rough ? D(c.tangent, c.tangent) : 0, island.before[c.normal],
                                   rough ? island.before[c.tangent] : 0, c.friction, c.restitution);
  c.impulse_n = impact.impulse_n;
  c.impulse_t = impact.impulse_t;
  island.normal_work += impact.normal_work;
  island.tangential_work += impact.tangential_work;
  island.solution.solved = impact.ended;
  return impact.ended;
}

}  // namespace freeplay
