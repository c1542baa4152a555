#include "formulations/contact/contact_problem.hpp"

#include <fmt/format.h>
#include <Eigen/QR>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "numerics/complementarity.hpp"

namespace freeplay {

long number_of_modes(const ContactEquations& problem) {
  long number = 1;
  for (const auto& c : problem.unknowns) {
    const int ways = (c.normal >= 0) + (c.tangent >= 0 ? 3 : c.normal >= 0);
    if (number > 1'000'000'000 / ways) return 1'000'000'000;
    number *= ways;
  }
  return number;
}

ContactModes find_modes(const ContactEquations& p, int most, long left) {
  const auto& unknowns = p.unknowns;
  const auto& D = p.D;
  const auto& b = p.b;
  const int rows = p.rows;
  using Way = ContactMode::Way;
  ContactModes result;
  const int n = static_cast<int>(unknowns.size());
  if (n > most_for_modes || number_of_modes(p) > left) return result;
  result.decided = true;
  const double size = std::max({p.scale(), p.least_scale, 1e-300}), none = 1e-8 * size;
  std::vector<Way> way(n);
  const auto first = [&](int i) { return unknowns[i].normal < 0 ? Way::stick : Way::open; };
  const auto last = [&](int i) { return unknowns[i].tangent < 0 ? Way::stick : Way::left; };
  for (int i = 0; i < n; ++i) way[i] = first(i);
  Eigen::MatrixXd cone(rows, 0), K;
  Eigen::VectorXd P(rows), fixed(rows), u(rows), x, y;
  std::vector<int> zero;
  std::vector<Eigen::VectorXd> edges;
  for (;;) {
    // The force of a contact lies in a cone with no edge (open), one edge (slip) or two (stick);
    // the rates of the rows `zero` vanish. The force of a preloaded joint is its bound (slip), or
    // minus the bound plus up to twice the bound (stick).
    zero.clear();
    edges.clear();
    fixed.setZero();
    const auto edge = [&](int normal, int tangent, double slope) {
      Eigen::VectorXd e = Eigen::VectorXd::Zero(rows);
      if (normal >= 0) e[normal] = 1;
      if (tangent >= 0) e[tangent] = slope;
      edges.push_back(e);
    };
    for (int i = 0; i < n; ++i) {
      const auto& c = unknowns[i];
      if (way[i] == Way::open) continue;
      const double side = way[i] == Way::right ? -1 : way[i] == Way::left ? 1 : 0;
      if (c.normal >= 0) zero.push_back(c.normal);
      if (c.tangent < 0) {
        edge(c.normal, -1, 0);
      } else if (side != 0) {
        fixed[c.tangent] += side * c.bound;
        if (c.normal >= 0) edge(c.normal, c.tangent, side * c.friction);
      } else {
        zero.push_back(c.tangent);
        if (c.normal >= 0) {
          edge(c.normal, c.tangent, c.friction);
          edge(c.normal, c.tangent, -c.friction);
        }
        if (c.bound > 0) {
          fixed[c.tangent] -= c.bound;
          edge(-1, c.tangent, 1);
        }
      }
    }
    ++result.tried;
    P = fixed;
    if (!edges.empty()) {
      cone.resize(rows, static_cast<Eigen::Index>(edges.size()));
      for (std::size_t j = 0; j < edges.size(); ++j) cone.col(static_cast<Eigen::Index>(j)) = edges[j];
      const Eigen::MatrixXd rates = D.topLeftCorner(rows, rows) * cone;
      K = rates(zero, Eigen::all);
      y.resize(static_cast<Eigen::Index>(zero.size()));
      u = b.head(rows) + D.topLeftCorner(rows, rows) * fixed;
      for (const auto& c : unknowns) {
        if (c.normal >= 0) u[c.normal] -= c.target_n;
        if (c.tangent >= 0) u[c.tangent] -= c.target_t;
      }
      y = -u(zero);
      const double column = std::max(K.cwiseAbs().maxCoeff(), 1e-300);
      K /= column;
      nonnegative_least_squares(K, y, x, 1e-13 * size);
      P += cone * x / column;
    }
    u = b.head(rows) + D.topLeftCorner(rows, rows) * P;
    bool consistent = true;
    for (int i = 0; i < n && consistent; ++i) {
      const auto& c = unknowns[i];
      if (c.normal >= 0) {
        const double rate = u[c.normal] - c.target_n;
        consistent = way[i] == Way::open ? rate >= -none : std::abs(rate) <= none;
      }
      if (c.tangent < 0 || way[i] == Way::open) continue;
      const double slide = u[c.tangent] - c.target_t;
      if (way[i] == Way::stick)
        consistent =
            consistent && std::abs(slide) <= none &&
            (c.bound == 0 ||
             std::abs(P[c.tangent]) <= c.bound * (1 + 1e-9) + c.friction * (c.normal >= 0 ? P[c.normal] : 0));
      else
        consistent = consistent && (way[i] == Way::right ? slide : -slide) >= -none;
    }
    const bool known =
        consistent && std::ranges::any_of(result.motions, [&](const ContactMode& m) {
          return (m.rates - u).cwiseAbs().maxCoeff() <= 1e-6 * (size + u.cwiseAbs().maxCoeff());
        });
    if (consistent && !known) {
      result.motions.push_back({way, P, u});
      if (static_cast<int>(result.motions.size()) >= most) return result;
    }
    int i = 0;
    for (; i < n; ++i) {
      if (way[i] < last(i)) {
        way[i] = static_cast<Way>(static_cast<int>(way[i]) + 1);
        break;
      }
      way[i] = first(i);
    }
    if (i == n) return result;
  }
}

std::vector<ContactModes> doubtful_motions(const ContactEquations& problem, long left,
                                           std::vector<std::vector<int>>& members) {
  std::vector<int> label;
  std::vector<ContactModes> found;
  members.clear();
  const int islands = problem.label_islands(label);
  for (int k = 0; k < islands; ++k) {
    std::vector<int> of;
    const auto part = problem.island(label, k, of);
    if (!part.doubtful()) continue;
    found.push_back(find_modes(part, 4, left));
    left -= found.back().tried;
    members.push_back(of);
  }
  return found;
}

std::string describe_motions(const ContactEquations& problem, const std::function<std::string(int)>& name,
                             const char* unit) {
  using Way = ContactMode::Way;
  std::vector<std::vector<int>> members;
  constexpr long enough = 1'000'000;  // what a solve has found is always described
  const auto islands = doubtful_motions(problem, enough, members);
  std::string text;
  for (std::size_t k = 0; k < islands.size(); ++k) {
    if (islands[k].motions.size() < 2) continue;
    std::string island;
    for (const auto& motion : islands[k].motions) {
      std::string one;
      int row = 0;
      for (std::size_t i = 0; i < members[k].size(); ++i) {
        const auto& u = problem.unknowns[members[k][i]];
        const double force = u.normal >= 0 ? motion.impulses[row] : 0;
        row += (u.normal >= 0) + (u.tangent >= 0);
        const auto way = motion.ways[i];
        if (!one.empty()) one += ", ";
        one += name(members[k][i]) + ' ';
        if (way == Way::open)
          one += "open";
        else if (u.tangent < 0)
          one += fmt::format("pressed with {:.3g} {}", force, unit);
        else
          one += fmt::format("{} with {:.3g} {}",
                             way == Way::stick   ? "sticking"
                             : way == Way::right ? "sliding to the right"
                                                 : "sliding to the left",
                             force, unit);
      }
      island += island.empty() ? one : "; or " + one;
    }
    text += text.empty() ? island : "; and " + island;
  }
  return text;
}

void ContactSolution::count(Work& work, Extremes& extremes) const {
  work.pivots += pivots;
  work.lcp_retries += retries;
  extremes.lcp_residual = std::max(extremes.lcp_residual, residual);
  extremes.lcp_residual_rate = std::max(extremes.lcp_residual_rate, residual_rate);
  extremes.ambiguous += ambiguous;
}

void ContactProblem::reserve(int size) {
  if (size <= D.rows()) return;
  ContactEquations::reserve(size);
  room_.last.reserve(static_cast<std::size_t>(size));
  room_.rates.setZero(size);
  room_.factor.setZero(size, size);
}

void ContactProblem::reserve_rates(int size) {
  ContactEquations::reserve_rates(size);
  room_.last.reserve(static_cast<std::size_t>(size));
}

/// The solvers to try, in this order: the named one or, if none is named, the cheapest for the size
/// of the problem; then the others of Lemke's method, Newton's method and mixed sweeps.
std::array<Solver*, 4> ContactProblem::order() const {
  const auto n = static_cast<int>(unknowns.size());
  if (n == 1 && singular_pair(*this, unknowns.front()))
    // which impulses to take is decided by a rule, not by a solver
    return {closed_form, lemke, newton, nullptr};
  Solver* first = named_solver(solver_);
  if (first == enumeration && n > most_for_enumeration) first = lemke;
  if (!first)
    first = n == 1 ? closed_form : n == 2 ? enumeration : n <= most_for_lemke ? lemke : mixed_gauss_seidel;
  std::array<Solver*, 4> order{first};
  const bool swept = first == closed_form || first == gauss_seidel;  // further sweeps gain nothing
  std::size_t next = 1;
  for (Solver* other : {lemke, newton, mixed_gauss_seidel})
    if (other != first && !(swept && other == mixed_gauss_seidel)) order[next++] = other;
  return order;
}

/// Sets the residuals of the present impulses.
void ContactProblem::finish(ContactSolution& s, double size) const {
  s.residual_rate = residual();
  s.residual = size > 0 ? s.residual_rate / size : s.residual_rate;
}

/// A single unknown whose closed form holds: the way of solve() in this case. Returns false if that
/// must look further.
bool ContactProblem::alone(ContactSolution& s, double size) {
  auto& c = unknowns.front();
  const int n = c.normal, t = c.tangent;
  const bool least_known = least == Least::never || least == Least::where_singular;
  if (n < 0 || t < 0 || solver_ != LcpSolver::automatic || !least_known) return false;
  const double nn = D(n, n), nt = D(n, t), tt = D(t, t), bn = b[n], bt = b[t];
  if (singular_pair(*this, c) || !solve_one(c, bn, bt, nn, nt, tt)) return false;
  const double Pn = c.impulse_n, Pt = c.impulse_t;
  if (!std::isfinite(Pn) || !std::isfinite(Pt)) return false;
  s.residual_rate = contact_residual(
      unknowns,
      [&](std::size_t) {
        return RowState{bn + nn * Pn + nt * Pt, nn, Pn};
      },
      [&](std::size_t) {
        return RowState{bt + D(t, n) * Pn + tt * Pt, tt, Pt};
      });
  if (!std::isfinite(s.residual_rate) ||
      !(s.residual_rate <= tolerance_ * size || s.residual_rate <= attainable()))
    return false;
  s.pivots = SolverSummary{}.iterations;
  s.residual = size > 0 ? s.residual_rate / size : s.residual_rate;
  if (Pn > 0 && nn <= c.friction * std::abs(nt)) look_for_others(s);
  return true;
}

ContactSolution ContactProblem::solve() {
  ContactSolution s;
  if (unknowns.empty()) return s;
  const double size = std::max(scale(), least_scale), accepted = tolerance_ * size;
  if (unknowns.size() == 1) {
    if (alone(s, size)) return s;
    s = {};
  }
  s.solved = false;
  if (static_cast<int>(unknowns.size()) > most_for_lemke && solver_ == LcpSolver::automatic &&
      by_islands(s)) {
    if (s.solved && wants_least(least, *this, room_)) use_least_impulses(*this, accepted, true);
    finish(s, size);
    return s;
  }
  // Rounding may keep all solvers from the tolerance. The best result is then accepted, up to this
  // relative residual.
  constexpr double loosest = 1e-6;
  std::vector<ContactUnknown> best;
  double best_rate = loosest * size;
  bool assessed = false;  // whether residual_rate belongs to the present impulses
  const auto keep = [&] {
    const double left = residual();
    if (!(left < best_rate)) return;
    best_rate = left;
    best = unknowns;
  };
  for (Solver* solver : order()) {
    if (!solver) break;
    for (auto& c : unknowns)  // discard the impulses of a solver that failed
      if (s.retries > 0) c.impulse_n = c.impulse_t = 0;
    const auto found = solver(*this, accepted, room_);
    s.pivots += found.iterations;
    s.residual_rate = residual();
    s.solved = found.solved && std::isfinite(s.residual_rate) &&
               (s.residual_rate <= accepted || s.residual_rate <= attainable());
    if (s.solved) {
      assessed = true;
      break;
    }
    keep();
    ++s.retries;
  }
  for (const auto last_resort : {copositive_lemke, proximal}) {
    if (s.solved || unknowns.size() == 1) break;
    const auto found = last_resort(*this, accepted, room_);
    s.pivots += found.iterations;
    s.solved = found.solved;
    keep();
  }
  if (!s.solved && !best.empty()) {
    unknowns = best;
    s.solved = true;
  }
  s.solved = s.solved || (std::isfinite(size) && finite() && by_modes(s));
  if (least != Least::never && std::isfinite(size) && finite() && wants_least(least, *this, room_)) {
    s.solved = use_least_impulses(*this, accepted, s.solved) || s.solved;
    assessed = false;
  }
  if (!assessed) s.residual_rate = residual();
  s.residual = size > 0 ? s.residual_rate / size : s.residual_rate;
  if (s.solved && doubtful()) look_for_others(s);
  return s;
}

/// Determines whether friction admits motions other than the present one.
void ContactProblem::look_for_others(ContactSolution& s) {
  std::vector<std::vector<int>> members;
  for (const auto& m : doubtful_motions(*this, modes_left, members)) {
    s.ambiguous |= m.decided && m.motions.size() > 1;
    s.undecided |= !m.decided;
    modes_left -= m.tried;
  }
}

/// Solves each island separately; returns false if there is only one.
bool ContactProblem::by_islands(ContactSolution& s) {
  std::vector<int> label, members;
  const int islands = label_islands(label);
  if (islands < 2) return false;
  s.solved = true;
  for (int k = 0; k < islands; ++k) {
    ContactProblem part(solver_, tolerance_);
    static_cast<ContactEquations&>(part) = island(label, k, members);
    part.modes_left = modes_left;
    const auto one = part.solve();
    modes_left = part.modes_left;
    s.solved = s.solved && one.solved;
    s.ambiguous |= one.ambiguous;
    s.undecided |= one.undecided;
    s.impossible |= one.impossible;
    s.pivots += one.pivots;
    s.retries += one.retries;
    take_impulses(part, members);
  }
  return true;
}

/// Tries all modes, if they are few enough: takes the first consistent one, or finds that there is
/// none.
bool ContactProblem::by_modes(ContactSolution& s) {
  const auto all = modes(1);
  modes_left -= all.tried;
  s.pivots += static_cast<int>(all.tried);
  s.impossible = all.decided && all.motions.empty();
  if (all.motions.empty()) return false;
  for (auto& c : unknowns) {
    c.impulse_n = c.normal >= 0 ? all.motions[0].impulses[c.normal] : 0;
    c.impulse_t = c.tangent >= 0 ? all.motions[0].impulses[c.tangent] : 0;
  }
  return true;
}

}  // namespace freeplay
