#include "formulations/contact/impact.hpp"

#include <fmt/format.h>

namespace freeplay {

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
