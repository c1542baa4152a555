#include "formulations/contact/impact.hpp"

#include <fmt/format.h>
#include <Eigen/Cholesky>
#include <Eigen/LU>

#include <algorithm>
#include <cmath>

namespace freeplay {

// Newton's law, u_N⁺ ≥ −e u_N⁻ ⊥ P_N ≥ 0, −P_T ∈ μ P_N Sgn(u_T⁺ + e_T u_T⁻): a single contact
// problem.

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

// Poisson's law, P_N = e P_C + extra, extra ≥ 0 ⊥ u_N⁺ ≥ 0 in expansion: the expansion impulse of
// each contact is e times its compression impulse, plus an extra impulse where the contact would
// close otherwise.

bool poisson_impact(ImpactIsland& island, ImpactPhases& phases, ImpactContacts& contacts) {
  if (contacts.size() == 1) return routh_impact(ImpactLaw::poisson, island, contacts.front());
  std::vector<double> ratio;
  for (const auto& c : contacts) ratio.push_back(c.restitution);
  if (!phases.compress(island, contacts) || !phases.expand(island, contacts, ratio)) return false;
  phases.add_works(island);
  return true;
}

// The energetic law. For several contacts i that D couples, the conditions are
//
//     z_i (u_N + u_N⁺)_i = 2 e_i² W_i,   z = r P_C,   W the absorbed work of compression, ≥ 0,
//
// with the rates u_N after compression and the impulses z of expansion. Without friction, u_N = 0
// and u_N⁺ = D z, so that z minimises ½ zᵀD z − Σ 2 e_i² W_i ln z_i. This function is convex; its
// minimum is unique, and Newton's method converges to it from any starting point. From there,
// Newton's method solves the condition itself, with friction in expansion.

namespace {

/// Solves z_i (D z)_i = work_i for z > 0; returns false if D lets impulses grow without any motion.
bool without_friction(const Eigen::MatrixXd& D, const Eigen::VectorXd& work, Eigen::VectorXd& z) {
  const auto value = [&](const Eigen::VectorXd& x) {
    return 0.5 * x.dot(D * x) - work.dot(x.array().log().matrix());
  };
  // Relative residual of each condition. Rounding hides the remaining decrease of `value` long
  // before it hides this residual.
  const auto miss = [&](const Eigen::VectorXd& x) {
    return (x.cwiseProduct(D * x) - work).cwiseQuotient(work).cwiseAbs().maxCoeff();
  };
  z = (work.array() / D.diagonal().array()).sqrt();
  for (int i = 0; i < 100; ++i) {
    const double left = miss(z);
    if (!(left > 1e-13)) return true;
    const Eigen::VectorXd slope = D * z - work.cwiseQuotient(z);
    Eigen::MatrixXd curved = D;
    curved.diagonal() += work.cwiseQuotient(z.cwiseAbs2());
    const Eigen::VectorXd step = curved.llt().solve(-slope);
    double length = 1;
    for (Eigen::Index k = 0; k < z.size(); ++k)
      if (step[k] < 0) length = std::min(length, -0.9 * z[k] / step[k]);
    const double now = value(z), fall = slope.dot(step);
    const auto better = [&](const Eigen::VectorXd& x) {
      return value(x) <= now + 0.1 * length * fall || miss(x) <= 0.5 * left;
    };
    while (length > 1e-10 && !better(z + length * step)) length *= 0.5;
    if (!(length > 1e-10)) break;
    z += length * step;
  }
  return miss(z) <= 1e-10;
}

/// Compression, then expansion with ratios that give each contact its work. Uses Poisson's ratios
/// if none are found.
bool expand_by_works(ImpactIsland& island, ImpactPhases& phases, ImpactContacts& contacts) {
  constexpr int most = 30;
  constexpr double met = 1e-11;
  if (!phases.compress(island, contacts)) return false;
  const auto& compression = phases.compression();
  std::vector<double> poisson, ratio;
  std::vector<int> at, row;  // contacts that expand, and their rows
  std::vector<double> owed;
  double greatest = 0;
  for (const auto& c : compression) greatest = std::max(greatest, -2 * c.work_n);
  for (std::size_t k = 0; k < contacts.size(); ++k) {
    const auto& c = contacts[k];
    const double work = -2 * compression[k].work_n;
    poisson.push_back(c.restitution);
    ratio.push_back(c.restitution);
    // Impulses at the level of rounding have no work to return.
    const double none = 1e-10 * island.greatest_rate();
    if (c.restitution == 0 || compression[k].impulse_n * island.problem.D(c.normal, c.normal) <= none)
      continue;
    if (!(work > 1e-12 * greatest)) {
      // The contact was compressed without work, as between bodies that come into contact and stop
      // together. It returns no work in expansion, where it only gets the impulse that keeps it
      // from closing.
      if (work > -1e-12 * greatest) ratio.back() = 0;
      continue;
    }
    at.push_back(static_cast<int>(k));
    row.push_back(c.normal);
    owed.push_back(c.restitution * c.restitution * work);
  }
  const auto n = static_cast<Eigen::Index>(at.size());
  if (n == 0) return phases.expand(island, contacts, poisson);
  const Eigen::VectorXd work = Eigen::Map<const Eigen::VectorXd>(owed.data(), n);
  Eigen::VectorXd z, left(n), trial(n);
  // Relative residual of each contact's condition.
  const auto miss = [&](const Eigen::VectorXd& impulse, Eigen::VectorXd& out) {
    for (Eigen::Index i = 0; i < n; ++i) ratio[at[i]] = impulse[i] / compression[at[i]].impulse_n;
    if (!phases.expand(island, contacts, ratio)) return false;
    for (Eigen::Index i = 0; i < n; ++i) out[i] = 2 * phases.expansion()[at[i]].work_n / work[i] - 1;
    return out.allFinite();
  };
  const Eigen::MatrixXd D = island.problem.D(row, row);
  bool found = without_friction(D, work, z) && miss(z, left);
  for (int i = 0; found && i < most && left.cwiseAbs().maxCoeff() > met; ++i) {
    Eigen::MatrixXd J(n, n);  // finite differences of a piecewise smooth condition
    for (Eigen::Index k = 0; found && k < n; ++k) {
      Eigen::VectorXd moved = z;
      moved[k] *= 1 + 1e-7;
      found = miss(moved, trial);
      J.col(k) = (trial - left) / (moved[k] - z[k]);
    }
    if (!found) break;
    const Eigen::VectorXd step = J.partialPivLu().solve(-left);
    found = false;
    // wedged: no impulse changes the residual
    if (!((step.cwiseQuotient(z)).maxCoeff() < 100)) break;
    for (double length = 1; !found && length > 1e-2; length *= 0.5) {
      const Eigen::VectorXd next = z + length * step;
      found = (next.array() > 0).all() && miss(next, trial) &&
              trial.cwiseAbs().maxCoeff() < left.cwiseAbs().maxCoeff();
      if (found) z = next;
    }
    left = trial;
  }
  if (found && left.cwiseAbs().maxCoeff() <= met) return miss(z, left);
  if (!phases.expand(island, contacts, poisson)) return false;
  island.wedged = true;
  return true;
}

}  // namespace

bool energetic_impact(ImpactIsland& island, ImpactPhases& phases, ImpactContacts& contacts) {
  if (contacts.size() == 1) return routh_impact(ImpactLaw::energetic, island, contacts.front());
  if (!expand_by_works(island, phases, contacts)) return false;
  phases.add_works(island);
  return true;
}

/// Solves the impact of the contacts that D couples, with the D and rates of island_.
std::string ImpactProblem::solve_island(std::vector<ImpactContact>& contacts) {
  auto& island = island_;
  const double normal = island.normal_work, tangential = island.tangential_work;
  const double residual = island.solution.residual, rate = island.solution.residual_rate;
  if (impact_by(law_, island, phases_, contacts)) return "";
  island.normal_work = normal;
  island.tangential_work = tangential;
  island.solution.residual = residual;  // a rejected solution leaves no residual
  island.solution.residual_rate = rate;
  // Without restitution there always is a solution (see copositive_lemke()).
  auto soft = contacts;
  for (auto& c : soft) c.restitution = c.tangential_restitution = 0;
  if (!newton_impact(island, phases_, soft))
    return fmt::format(
        "no solver solved the impact of {} contacts, even without restitution (relative residual {:.2g}); "
        "a solution may exist",
        contacts.size(), island.solution.residual);
  inelastic_ = true;
  for (std::size_t i = 0; i < soft.size(); ++i) {
    contacts[i].impulse_n = soft[i].impulse_n;
    contacts[i].impulse_t = soft[i].impulse_t;
  }
  return "";
}

std::string ImpactProblem::solve(const Eigen::MatrixXd& D, const Eigen::VectorXd& u, int rows,
                                 std::vector<ImpactContact>& contacts) {
  auto& problem = island_.problem;
  island_.solution = {};
  inelastic_ = island_.wedged = false;
  island_.normal_work = island_.tangential_work = 0;
  problem.reserve(rows);
  problem.rows = rows;
  problem.D.topLeftCorner(rows, rows) = D.topLeftCorner(rows, rows);
  island_.pose(contacts);
  std::vector<int> label, of;
  const int islands = problem.label_islands(label);
  std::vector<ImpactContact> part;
  for (int k = 0; k < islands; ++k) {
    part.clear();
    of.clear();
    for (std::size_t i = 0; i < contacts.size(); ++i) {
      if (label[i] != k) continue;
      part.push_back(contacts[i]);
      for (int* row : {&part.back().normal, &part.back().tangent}) {
        if (*row < 0) continue;
        of.push_back(*row);
        *row = static_cast<int>(of.size()) - 1;
      }
    }
    problem.rows = static_cast<int>(of.size());
    problem.D.topLeftCorner(problem.rows, problem.rows) = D(of, of);
    island_.before = u(of);
    if (auto reason = solve_island(part); !reason.empty()) return reason;
    auto from = part.begin();
    for (std::size_t i = 0; i < contacts.size(); ++i) {
      if (label[i] != k) continue;
      contacts[i].impulse_n = from->impulse_n;
      contacts[i].impulse_t = from->impulse_t;
      ++from;
    }
  }
  return "";
}

}  // namespace freeplay
