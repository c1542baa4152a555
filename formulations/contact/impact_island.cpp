#include "formulations/contact/impact_island.hpp"

#include <algorithm>
#include <cmath>

namespace freeplay {

/// Along P_N the rates are piecewise linear,
///
///     du_N/dP = D_NN + c D_NT,   du_T/dP = D_NT + c D_TT,
///     c = −μ sgn u_T while slipping,   c = −D_NT/D_TT while sticking.
///
/// Sticking requires |c| ≤ μ; otherwise slip begins again in the direction that D_NT drives.
RouthImpact routh_impact(ImpactLaw law, double Dnn, double Dnt, double Dtt, double u_n, double u_t, double mu,
                         double e) {
  constexpr double none = 1e-12;  // relative: rounding error of rows that depend on one freedom
  RouthImpact impact;
  if (!(u_n < 0)) return impact;
  const bool poisson = law == ImpactLaw::poisson;
  bool compressing = true;
  double wanted = 0;  // normal impulse or normal work at the end, set when compression is over
  const bool rough = Dtt > none * Dnn;
  const double stick = rough ? -Dnt / Dtt : 0;
  const double stick_rise = rough && Dnn * Dtt - Dnt * Dnt <= none * Dnn * Dtt ? 0 : Dnn + stick * Dnt;
  if (!rough && std::abs(u_t) <= none * -u_n) u_t = 0;
  for (int phase = 0; phase < 12; ++phase) {
    const bool sticks = u_t == 0 && std::abs(stick) <= mu;
    const double c = u_t != 0 ? -std::copysign(mu, u_t) : sticks ? stick : std::copysign(mu, stick);
    const double rise_n = sticks ? stick_rise : Dnn + c * Dnt;
    const double rise_t = sticks || !rough ? 0 : Dnt + c * Dtt;
    // Length of this piece in P: until slip stops, compression ends, or expansion has reached its
    // impulse or its work.
    double length = INFINITY;
    if (compressing) {
      if (rise_n > 0) length = -u_n / rise_n;
    } else if (poisson) {
      length = wanted - impact.impulse_n;
    } else {
      // u_N x + ½ rise x² = remaining work
      const double left = wanted - impact.normal_work, root = u_n * u_n + 2 * rise_n * left;
      if (const double end = u_n + std::sqrt(std::max(0.0, root)); root >= 0 && end > 0)
        length = 2 * left / end;
      else if (u_n == 0 && rise_n <= 0)
        return impact;  // wedged: friction keeps the energy stored in compression
    }
    const double stop = u_t * rise_t < 0 ? -u_t / rise_t : INFINITY;
    const bool ends = length <= stop * (1 + none), slip_stops = stop <= length * (1 + none);
    length = std::min(length, stop);
    if (!std::isfinite(length)) {
      impact.ended = false;
      return impact;
    }
    impact.normal_work += length * (u_n + 0.5 * rise_n * length);
    impact.tangential_work += c * length * (u_t + 0.5 * rise_t * length);
    impact.impulse_n += length;
    impact.impulse_t += c * length;
    u_n += rise_n * length;
    u_t = slip_stops || sticks ? 0 : u_t + rise_t * length;
    if (!ends) continue;
    if (!compressing || e == 0) return impact;
    u_n = 0;
    compressing = false;
    // the work is negative
    wanted = poisson ? impact.impulse_n * (1 + e) : impact.normal_work * (1 - e * e);
  }
  impact.ended = false;
  return impact;
}

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
