#include "numerics/rank.hpp"

#include <Eigen/OrderingMethods>
#include <Eigen/SparseCore>
#include <Eigen/SparseQR>
#include <algorithm>
#include <cmath>

namespace freeplay {

std::vector<int> independent_rows(const CsrPattern& G, std::span<const double> values,
                                  std::span<const double> mass, double tolerance) {
  if (G.rows == 0) return {};
  std::vector<Eigen::Triplet<double>> entries;
  for (int k = 0; k < G.rows; ++k) {
    const auto first = (G.begin[k]);
    const auto last = (G.begin[k + 1]);
    const auto weighted = [&](std::size_t e) { return values[e] / std::sqrt(mass[G.column[e]]); };
    double norm = 0;
    for (auto e = first; e < last; ++e) norm = std::hypot(norm, weighted(e));
    if (norm == 0) continue;
    for (auto e = first; e < last; ++e) entries.emplace_back(G.column[e], k, weighted(e) / norm);
  }
  Eigen::SparseMatrix<double> transposed(G.columns, G.rows);
  transposed.setFromTriplets(entries.begin(), entries.end());
  Eigen::SparseQR<Eigen::SparseMatrix<double>, Eigen::COLAMDOrdering<int>> qr;
  qr.setPivotThreshold(tolerance);
  qr.compute(transposed);
  std::vector<int> rows;
  for (int i = 0; i < static_cast<int>(qr.rank()); ++i) rows.push_back(qr.colsPermutation().indices()[i]);
  std::ranges::sort(rows);
  return rows;
}

}  // namespace freeplay
