#include "formulations/contact/impact.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "formulations/contact/routh.hpp"

namespace freeplay {

void ImpactProblem::prepare(const std::vector<ImpactContact>& contacts) {
  problem_.unknowns.clear();
  for (const auto& c : contacts) {
    ContactUnknown x;
    x.normal = c.normal;
    x.tangent = c.tangent;
    x.friction = c.friction;
    x.bound = c.bound;
    problem_.unknowns.push_back(x);
  }
}

/// Adds what an impulse does to the rates.
void ImpactProblem::act(Eigen::VectorXd& rates, const ImpactContact& by) const {
  const int m = problem_.rows;
  if (by.normal >= 0) rates.head(m) += by.impulse_n * problem_.D.col(by.normal).head(m);
  if (by.tangent >= 0) rates.head(m) += by.impulse_t * problem_.D.col(by.tangent).head(m);
}

/// Works of impulses that grow together, from `before_` to `after_`.
void ImpactProblem::book_at_once(const std::vector<ImpactContact>& contacts) {
  for (const auto& c : contacts) {
    if (c.normal >= 0) normal_work_ += 0.5 * c.impulse_n * (before_[c.normal] + after_[c.normal]);
    if (c.tangent >= 0) tangential_work_ += 0.5 * c.impulse_t * (before_[c.tangent] + after_[c.tangent]);
  }
}

bool ImpactProblem::solve_problem() {
  const auto one = problem_.solve();
  solution_.solved = one.solved;
  solution_.residual = std::max(solution_.residual, one.residual);
  solution_.residual_rate = std::max(solution_.residual_rate, one.residual_rate);
  solution_.pivots += one.pivots;
  solution_.retries += one.retries;
  solution_.ambiguous |= one.ambiguous;
  solution_.undecided |= one.undecided;
  solution_.impossible |= one.impossible;
  return one.solved;
}

bool ImpactProblem::newton(std::vector<ImpactContact>& contacts) {
  const int m = problem_.rows;
  prepare(contacts);
  problem_.b.head(m) = before_.head(m);
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    auto& x = problem_.unknowns[i];
    const auto& c = contacts[i];
    if (c.normal < 0 || before_[c.normal] >= 0) continue;
    x.target_n = -c.restitution * before_[c.normal];
    if (c.tangent >= 0) x.target_t = -c.tangential_restitution * before_[c.tangent];
  }
  if (!solve_problem()) return false;
  after_ = before_;
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    contacts[i].impulse_n = problem_.unknowns[i].impulse_n;
    contacts[i].impulse_t = problem_.unknowns[i].impulse_t;
    act(after_, contacts[i]);
  }
  return true;
}

bool ImpactProblem::routh(ImpactContact& c) {
  const auto& D = problem_.D;
  const bool rough = c.tangent >= 0;
  const auto impact = routh_impact(law_, D(c.normal, c.normal), rough ? D(c.normal, c.tangent) : 0,
                                   rough ? D(c.tangent, c.tangent) : 0, before_[c.normal],
                                   rough ? before_[c.tangent] : 0, c.friction, c.restitution);
  c.impulse_n = impact.impulse_n;
  c.impulse_t = impact.impulse_t;
  normal_work_ += impact.normal_work;
  tangential_work_ += impact.tangential_work;
  solution_.solved = impact.ended;
  return impact.ended;
}

bool ImpactProblem::by_law(std::vector<ImpactContact>& contacts) {
  switch (law_) {
    case ImpactLaw::newton:
      if (!newton(contacts)) return false;
      book_at_once(contacts);
      return true;
    case ImpactLaw::energetic:
      if (contacts.size() == 1) return routh(contacts.front());
      if (!energetic(contacts)) return false;
      break;
    case ImpactLaw::poisson: {
      if (contacts.size() == 1) return routh(contacts.front());
      std::vector<double> ratio;
      for (const auto& c : contacts) ratio.push_back(c.restitution);
      if (!compress(contacts) || !expand(contacts, ratio)) return false;
      break;
    }
  }
  for (const auto* phase : {&compression_, &expansion_})
    for (const auto& c : *phase) {
      normal_work_ += c.work_n;
      tangential_work_ += c.work_t;
    }
  return true;
}

/// Of contacts that D couples, with problem_.D and before_ theirs.
std::string ImpactProblem::solve_island(std::vector<ImpactContact>& contacts) {
  const double normal = normal_work_, tangential = tangential_work_;
  const double residual = solution_.residual, rate = solution_.residual_rate;
  if (by_law(contacts)) return "";
  normal_work_ = normal;
  tangential_work_ = tangential;
  solution_.residual = residual;  // what is not taken leaves nothing
  solution_.residual_rate = rate;
  // Without restitution there always is a solution (see by_copositive_lemke).
  auto soft = contacts;
  for (auto& c : soft) c.restitution = c.tangential_restitution = 0;
  if (!newton(soft))
    return fmt::format(
        "the impact of {} contacts was not solved by any solver, nor without restitution (residual {:.2g} of the "
        "greatest rate); whether it has a solution is not known",
        contacts.size(), solution_.residual);
  inelastic_ = true;
  book_at_once(soft);
  for (std::size_t i = 0; i < soft.size(); ++i) {
    contacts[i].impulse_n = soft[i].impulse_n;
    contacts[i].impulse_t = soft[i].impulse_t;
  }
  return "";
}

std::string ImpactProblem::solve(const Eigen::MatrixXd& D, const Eigen::VectorXd& u, int rows,
                                 std::vector<ImpactContact>& contacts) {
  solution_ = {};
  inelastic_ = wedged_ = false;
  normal_work_ = tangential_work_ = 0;
  problem_.reserve(rows);
  problem_.rows = rows;
  problem_.D.topLeftCorner(rows, rows) = D.topLeftCorner(rows, rows);
  prepare(contacts);
  std::vector<int> label, of;
  const int islands = problem_.label_islands(label);
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
    problem_.rows = static_cast<int>(of.size());
    problem_.D.topLeftCorner(problem_.rows, problem_.rows) = D(of, of);
    before_ = u(of);
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
