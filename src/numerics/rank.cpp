#include "numerics/rank.hpp"

#include <Eigen/OrderingMethods>
#include <Eigen/SparseCore>
#include <Eigen/SparseQR>
#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

namespace freeplay {
namespace {

/// Rows that share columns, directly or over others, together: in the order of their first rows.
std::vector<std::vector<int>> components(const CsrPattern& G) {
  std::vector<int> root(G.columns);
  std::iota(root.begin(), root.end(), 0);
  const auto find = [&](int c) {
    while (root[c] != c) c = root[c] = root[root[c]];
    return c;
  };
  for (int k = 0; k < G.rows; ++k)
    for (int e = G.begin[k] + 1; e < G.begin[k + 1]; ++e)
      root[find(G.column[e])] = find(G.column[G.begin[k]]);
  std::vector<std::vector<int>> list;
  std::map<int, std::size_t> place;
  for (int k = 0; k < G.rows; ++k) {
    if (G.begin[k] == G.begin[k + 1]) continue;
    const auto [at, fresh] = place.try_emplace(find(G.column[G.begin[k]]), list.size());
    if (fresh) list.emplace_back();
    list[at->second].push_back(k);
  }
  return list;
}

}  // namespace

std::vector<int> independent_rows(const CsrPattern& G, std::span<const double> values,
                                  std::span<const double> mass, double tolerance) {
  std::vector<int> independent;
  std::map<int, int> column;  // of one component, in the order of the whole
  std::vector<Eigen::Triplet<double>> entries;
  for (const auto& rows : components(G)) {
    entries.clear();
    column.clear();
    for (const int k : rows)
      for (int e = G.begin[k]; e < G.begin[k + 1]; ++e) column[G.column[e]] = 0;
    for (int next = 0; auto& [of_whole, own] : column) own = next++;
    for (std::size_t i = 0; i < rows.size(); ++i) {
      const auto weighted = [&](int e) { return values[e] / std::sqrt(mass[G.column[e]]); };
      const int first = G.begin[rows[i]], last = G.begin[rows[i] + 1];
      double norm = 0;
      for (int e = first; e < last; ++e) norm = std::hypot(norm, weighted(e));
      if (norm == 0) continue;
      for (int e = first; e < last; ++e)
        entries.emplace_back(column[G.column[e]], static_cast<int>(i), weighted(e) / norm);
    }
    Eigen::SparseMatrix<double> transposed(static_cast<int>(column.size()), static_cast<int>(rows.size()));
    transposed.setFromTriplets(entries.begin(), entries.end());
    Eigen::SparseQR<Eigen::SparseMatrix<double>, Eigen::COLAMDOrdering<int>> qr;
    qr.setPivotThreshold(tolerance);
    qr.compute(transposed);
    for (int i = 0; i < static_cast<int>(qr.rank()); ++i)
      independent.push_back(rows[qr.colsPermutation().indices()[i]]);
  }
  std::ranges::sort(independent);
  return independent;
}

}  // namespace freeplay
