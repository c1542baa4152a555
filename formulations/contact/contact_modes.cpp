#include "formulations/contact/contact_modes.hpp"

#include <fmt/format.h>

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "numerics/least_squares.hpp"
#include "values/diagnostic.hpp"

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

std::string undecided_note(long count) { return diagnostic<Diagnostic::not_searched>(count, most_for_modes); }

}  // namespace freeplay
