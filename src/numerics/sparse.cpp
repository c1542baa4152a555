#include "numerics/sparse.hpp"

#include <Eigen/OrderingMethods>
#include <Eigen/SparseCore>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <utility>

namespace freeplay {
namespace {

/// Groups of rows that share columns directly or indirectly, in the order of their first rows.
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

/// The triangular factor of A = QR, built from the rows of A by Givens rotations (George and Heath,
/// Linear Algebra Appl. 34 (1980) 69). Q is not stored, so only R needs memory.
class Triangle {
 public:
  using Row = std::vector<std::pair<int, double>>;  ///< (column, value), ascending columns

  explicit Triangle(int columns) : rows_(static_cast<std::size_t>(columns)) {}

  void add(Row x) {
    while (!x.empty()) {
      auto& pivot = rows_[static_cast<std::size_t>(x.front().first)];
      if (pivot.empty()) {
        pivot = std::move(x);
        return;
      }
      rotate(pivot, x);
    }
  }

  /// Columns whose distance from the span of the earlier accepted columns exceeds `tolerance`. A
  /// smaller pivot is set to zero, and the remainder of its row is rotated into the rows below
  /// (Heath, SIAM J. Sci. Stat. Comput. 3 (1982) 223).
  std::vector<int> independent(double tolerance) {
    std::vector<int> found;
    for (std::size_t k = 0; k < rows_.size(); ++k) {
      if (rows_[k].empty()) continue;
      if (std::abs(rows_[k].front().second) > tolerance) {
        found.push_back(static_cast<int>(k));
        continue;
      }
      Row rest(rows_[k].begin() + 1, rows_[k].end());
      rows_[k].clear();
      add(std::move(rest));
    }
    return found;
  }

 private:
  /// Eliminates the first entry of x, which is in the first column of `pivot`.
  void rotate(Row& pivot, Row& x) {
    const double r = std::hypot(pivot.front().second, x.front().second);
    if (r == 0) {
      x.erase(x.begin());
      return;
    }
    const double c = pivot.front().second / r, s = x.front().second / r;
    above_.clear();
    below_.clear();
    auto p = pivot.begin(), o = x.begin();
    while (p != pivot.end() || o != x.end()) {
      const bool both = p != pivot.end() && o != x.end() && p->first == o->first;
      const bool in_pivot = both || o == x.end() || (p != pivot.end() && p->first < o->first);
      const int column = in_pivot ? p->first : o->first;
      const double a = in_pivot ? p->second : 0, b = both || !in_pivot ? o->second : 0;
      if (in_pivot) ++p;
      if (both || !in_pivot) ++o;
      above_.emplace_back(column, c * a + s * b);
      if (above_.size() > 1) below_.emplace_back(column, c * b - s * a);
    }
    above_.front().second = r;
    pivot.swap(above_);
    x.swap(below_);
  }

  std::vector<Row> rows_;  // by first column
  Row above_, below_;
};

}  // namespace

std::vector<int> independent_rows(const CsrPattern& G, std::span<const double> values,
                                  std::span<const double> mass, double tolerance) {
  std::vector<int> independent;
  std::map<int, int> column;  // of one component, in the order of the whole matrix
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
    Eigen::COLAMDOrdering<int>::PermutationType order;
    Eigen::COLAMDOrdering<int>()(transposed, order);
    const auto& place = order.indices();  // of each row of G among the columns of R
    std::vector<int> row_at(rows.size());
    for (std::size_t i = 0; i < rows.size(); ++i)
      row_at[static_cast<std::size_t>(place[static_cast<int>(i)])] = rows[i];
    std::vector<Triangle::Row> A(column.size());
    for (const auto& e : entries)
      A[static_cast<std::size_t>(e.row())].emplace_back(place[e.col()], e.value());
    for (auto& row : A) std::ranges::sort(row);
    // Rows whose last column comes first are added first, so that each meets few others (George and
    // Ng, SIAM J. Sci. Stat. Comput. 4 (1983) 187).
    std::ranges::stable_sort(A, {}, [](const auto& row) { return row.empty() ? -1 : row.back().first; });
    Triangle R(static_cast<int>(rows.size()));
    for (auto& row : A) R.add(std::move(row));
    for (const int k : R.independent(tolerance)) independent.push_back(row_at[static_cast<std::size_t>(k)]);
  }
  std::ranges::sort(independent);
  return independent;
}

}  // namespace freeplay
