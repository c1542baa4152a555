#include "formulations/contact/sparse_island.hpp"

#include <algorithm>
#include <cmath>

namespace freeplay {

double SparseIsland::rate(int row) const {
  double u = b[row];
  for (int e = begin[row]; e < begin[row + 1]; ++e) u += value[e] * impulse[column[e]];
  return u;
}

double SparseIsland::entry(int row, int col) const {
  for (int e = begin[row]; e < begin[row + 1]; ++e)
    if (column[e] == col) return value[e];
  return 0;
}

double SparseIsland::residual() const {
  const auto state = [&](int row) { return RowState{rate(row), entry(row, row), impulse[row]}; };
  return contact_residual(
      unknowns, [&](std::size_t i) { return state(unknowns[i].normal); },
      [&](std::size_t i) { return state(unknowns[i].tangent); });
}

double SparseIsland::attainable() const {
  double most = 0;
  for (std::size_t r = 0; r + 1 < begin.size(); ++r) {
    double sum = std::abs(b[r]);
    for (int e = begin[r]; e < begin[r + 1]; ++e) sum += std::abs(value[e] * impulse[column[e]]);
    most = std::max(most, sum);
  }
  return 1e-13 * most;
}

void SparseIsland::gather() {
  impulse.resize(slots.size());
  for (const auto& u : unknowns) {
    if (u.normal >= 0) impulse[u.normal] = u.impulse_n;
    if (u.tangent >= 0) impulse[u.tangent] = u.impulse_t;
  }
}

void SparseIsland::scatter() {
  for (auto& u : unknowns) {
    u.impulse_n = u.normal >= 0 ? impulse[u.normal] : 0;
    u.impulse_t = u.tangent >= 0 ? impulse[u.tangent] : 0;
  }
}

}  // namespace freeplay
