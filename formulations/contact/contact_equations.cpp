#include "formulations/contact/contact_equations.hpp"

#include <numeric>

namespace freeplay {

void ContactEquations::reserve(int size) {
  if (size <= D.rows()) return;
  D.conservativeResizeLike(Eigen::MatrixXd::Zero(size, size));
  b.conservativeResizeLike(Eigen::VectorXd::Zero(size));
  unknowns.reserve(size);
}

void ContactEquations::reserve_rates(int size) {
  b.setZero(std::max<Eigen::Index>(size, b.size()));
  unknowns.reserve(size);
}

double ContactEquations::rate(int row) const {
  double u = b[row];
  for (const auto& c : unknowns) {
    if (c.normal >= 0) u += D(row, c.normal) * c.impulse_n;
    if (c.tangent >= 0) u += D(row, c.tangent) * c.impulse_t;
  }
  return u;
}

double ContactEquations::scale() const {
  double size = 0;
  for (const auto& c : unknowns) {
    if (c.normal >= 0) size = std::max({size, std::abs(b[c.normal]), std::abs(c.target_n)});
    if (c.tangent >= 0) size = std::max({size, std::abs(b[c.tangent]), std::abs(c.target_t)});
  }
  return size;
}

double ContactEquations::residual() const {
  for (const auto& c : unknowns)
    if (!std::isfinite(c.impulse_n) || !std::isfinite(c.impulse_t)) return INFINITY;
  return contact_residual(unknowns, [&](int row, double P) { return RowState{rate(row), D(row, row), P}; });
}

double ContactEquations::attainable() const {
  double most = 0;
  for (const auto& c : unknowns)
    for (const int row : {c.normal, c.tangent}) {
      if (row < 0) continue;
      double sum = std::abs(b[row]);
      for (const auto& o : unknowns) {
        if (o.normal >= 0) sum += std::abs(D(row, o.normal) * o.impulse_n);
        if (o.tangent >= 0) sum += std::abs(D(row, o.tangent) * o.impulse_t);
      }
      most = std::max(most, sum);
    }
  return 1e-13 * most;
}

bool ContactEquations::doubtful() const {
  return std::ranges::any_of(unknowns, [&](const ContactUnknown& c) {
    if (c.normal < 0) return false;
    const double own = D(c.normal, c.normal);
    return c.tangent < 0 ? own <= 0 : c.impulse_n > 0 && own <= c.friction * std::abs(D(c.normal, c.tangent));
  });
}

int ContactEquations::label_islands(std::vector<int>& label) const {
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

ContactEquations ContactEquations::island(const std::vector<int>& label, int which,
                                          std::vector<int>& members) const {
  ContactEquations part;
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
  part.least_scale = std::max(scale(), least_scale);
  for (int r = 0; r < part.rows; ++r) {
    part.b[r] = b[rows_of[r]];
    for (int s = 0; s < part.rows; ++s) part.D(r, s) = D(rows_of[r], rows_of[s]);
  }
  return part;
}

void ContactEquations::take_impulses(const ContactEquations& island, const std::vector<int>& members) {
  for (std::size_t i = 0; i < members.size(); ++i) {
    unknowns[members[i]].impulse_n = island.unknowns[i].impulse_n;
    unknowns[members[i]].impulse_t = island.unknowns[i].impulse_t;
  }
}

}  // namespace freeplay
