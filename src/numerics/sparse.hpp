// Sparse rows: a fixed pattern with values that change, and a single short row for contacts.
#pragma once

#include <array>
#include <vector>

namespace freeplay {

/// Pattern of a matrix of `rows` rows by compressed rows; values live elsewhere, in the same order as
/// `column`.
struct CsrPattern {
  int rows = 0;
  int columns = 0;
  std::vector<int> begin{0};  ///< rows + 1 entries
  std::vector<int> column;

  void end_row() {
    ++rows;
    begin.push_back(static_cast<int>(column.size()));
  }
};

/// y_k = Σ_j value_kj x_j of one row.
inline double row_dot(const CsrPattern& p, const double* value, int k, const double* x) {
  double sum = 0;
  for (int e = p.begin[k]; e < p.begin[k + 1]; ++e) sum += value[e] * x[p.column[e]];
  return sum;
}

/// x += Gᵀ λ.
inline void add_transposed(const CsrPattern& p, const double* value, const double* lambda, double* x) {
  for (int k = 0; k < p.rows; ++k)
    for (int e = p.begin[k]; e < p.begin[k + 1]; ++e) x[p.column[e]] += value[e] * lambda[k];
}

/// A row that touches at most two bodies.
struct SparseRow {
  static constexpr int max_size = 6;  // two bodies in the plane
  int size = 0;
  std::array<int, max_size> column{};
  std::array<double, max_size> value{};

  void clear() { size = 0; }
  void push(int c, double x) {
    column[size] = c;
    value[size] = x;
    ++size;
  }
  double dot(const double* x) const {
    double sum = 0;
    for (int i = 0; i < size; ++i) sum += value[i] * x[column[i]];
    return sum;
  }
  void add_to(double* x, double factor) const {
    for (int i = 0; i < size; ++i) x[column[i]] += factor * value[i];
  }
};

}  // namespace freeplay
