// All consistent modes of a contact problem, island by island: whether there is a solution, and one motion.
#include <fmt/format.h>

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "formulations/contact/contact_problem.hpp"
#include "numerics/least_squares.hpp"

namespace freeplay {
int ContactProblem::label_islands(std::vector<int>& label) const {
  const auto n = unknowns.size();
  label.resize(n);
  std::iota(label.begin(), label.end(), 0);
  const auto root = [&](int i) {
    while (label[i] != i) i = label[i] = label[label[i]];
    return i;
  };
  const auto coupled = [&](int r, int s) {
    if (r < 0 || s < 0) return false;
    const double size = std::sqrt(std::abs(D(r, r) * D(s, s)));
    return std::abs(D(r, s)) > 1e-14 * size || std::abs(D(s, r)) > 1e-14 * size;
  };
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = 0; j < i; ++j)
      for (const int r : {unknowns[i].normal, unknowns[i].tangent})
        for (const int s : {unknowns[j].normal, unknowns[j].tangent})
          if (coupled(r, s)) label[root(static_cast<int>(i))] = root(static_cast<int>(j));
  int islands = 0;
  std::vector<int> number(n, -1);
  for (std::size_t i = 0; i < n; ++i) {
    const int r = root(static_cast<int>(i));
    if (number[r] < 0) number[r] = islands++;
  }
  std::vector<int> roots(n);
  for (std::size_t i = 0; i < n; ++i) roots[i] = number[root(static_cast<int>(i))];
  label = roots;
  return islands;
}

ContactProblem ContactProblem::island(const std::vector<int>& label, int which,
                                      std::vector<int>& members) const {
  ContactProblem part(solver_, tolerance_);
  members.clear();
  std::vector<int> rows_of;
  for (std::size_t i = 0; i < unknowns.size(); ++i) {
    if (label[i] != which) continue;
    members.push_back(static_cast<int>(i));
    auto u = unknowns[i];
    for (int* row : {&u.normal, &u.tangent})
      if (*row >= 0) {
        rows_of.push_back(*row);
        *row = part.rows++;
      }
    part.unknowns.push_back(u);
  }
  part.reserve(part.rows);
  part.modes_left = modes_left;
  part.least_scale_ = std::max(scale(), least_scale_);
  for (int r = 0; r < part.rows; ++r) {
    part.b[r] = b[rows_of[r]];
    for (int s = 0; s < part.rows; ++s) part.D(r, s) = D(rows_of[r], rows_of[s]);
  }
  return part;
}

long ContactProblem::number_of_modes() const {
  long number = 1;
  for (const auto& c : unknowns) {
    const int ways = (c.normal >= 0) + (c.tangent >= 0 ? 3 : c.normal >= 0);
    if (number > 1'000'000'000 / ways) return 1'000'000'000;
    number *= ways;
  }
  return number;
}

ContactModes ContactProblem::modes(int most) const {
  using Way = ContactMode::Way;
  ContactModes result;
  const int n = static_cast<int>(unknowns.size());
  if (n > most_for_modes || number_of_modes() > modes_left) return result;
  result.decided = true;
  const double size = std::max({scale(), least_scale_, 1e-300}), none = 1e-8 * size;
  std::vector<Way> way(n);
  const auto first = [&](int i) { return unknowns[i].normal < 0 ? Way::stick : Way::open; };
  const auto last = [&](int i) { return unknowns[i].tangent < 0 ? Way::stick : Way::left; };
  for (int i = 0; i < n; ++i) way[i] = first(i);
  Eigen::MatrixXd cone(rows, 0), K;
  Eigen::VectorXd P(rows), fixed(rows), u(rows), x, y;
  std::vector<int> zero;
  std::vector<Eigen::VectorXd> edges;
  for (;;) {
    // A contact's force lies in a cone with one edge (open: none; slip) or two (stick); what vanishes are
    // the rates of `zero`. A preloaded joint's force is its bound, or that and up to twice it back.
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

bool ContactProblem::doubtful() const {
  return std::ranges::any_of(unknowns, [&](const ContactUnknown& c) {
    if (c.normal < 0) return false;
    const double own = D(c.normal, c.normal);
    return c.tangent < 0 ? own <= 0 : c.impulse_n > 0 && own <= c.friction * std::abs(D(c.normal, c.tangent));
  });
}

std::vector<ContactModes> ContactProblem::doubtful_motions(std::vector<std::vector<int>>& members) const {
  std::vector<int> label;
  std::vector<ContactModes> found;
  members.clear();
  long left = modes_left;
  const int islands = label_islands(label);
  for (int k = 0; k < islands; ++k) {
    std::vector<int> of;
    auto part = island(label, k, of);
    if (!part.doubtful()) continue;
    part.modes_left = left;
    found.push_back(part.modes(4));
    left -= found.back().tried;
    members.push_back(of);
  }
  return found;
}

std::string describe_motions(const ContactProblem& problem, const std::function<std::string(int)>& name,
                             const char* unit) {
  using Way = ContactMode::Way;
  std::vector<std::vector<int>> members;
  auto asked = problem;
  asked.modes_left = 1'000'000;  // what a solve has found can be told
  const auto islands = asked.doubtful_motions(members);
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

std::string undecided_note(long count) {
  return fmt::format(
      "whether friction admits other motions was not decided in {} contact problems: they couple more than {} contacts, "
      "or the run had tried its number of modes",
      count, ContactProblem::most_for_modes);
}

}  // namespace freeplay
