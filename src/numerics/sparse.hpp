// Sparse rows: a constant pattern with varying values, and one short row for contacts.
#pragma once

#include <array>
#include <span>
#include <type_traits>
#include <vector>

namespace freeplay {

/// Pattern of a matrix in compressed row storage. The values are stored elsewhere, in the order of
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

/// Σ_j value_kj x_j of row k.
template <class T>
T row_dot(const CsrPattern& p, const T* value, int k, const T* x) {
  T sum = 0;
  for (int e = p.begin[k]; e < p.begin[k + 1]; ++e) sum += value[e] * x[p.column[e]];
  return sum;
}

/// x += Gᵀ λ.
template <class T>
void add_transposed(const CsrPattern& p, const T* value, const double* lambda, T* x) {
  for (int k = 0; k < p.rows; ++k)
    for (int e = p.begin[k]; e < p.begin[k + 1]; ++e) x[p.column[e]] += value[e] * lambda[k];
}

/// A row with entries of at most two bodies. T is double or a number with derivatives.
template <class T>
struct SparseRowOf {
  static constexpr int max_size = 6;  // two bodies in the plane
  int size = 0;
  std::array<int, max_size> column{};
  std::array<T, max_size> value{};

  template <class M>
  void serialize(M& m) {
    m(size, column, value);
  }
  void clear() { size = 0; }
  void push(int c, const T& x) {
    column[size] = c;
    value[size] = x;
    ++size;
  }
  T dot(const T* x) const {
    T sum = 0;
    each([&](int i) { sum += value[i] * x[column[i]]; });
    return sum;
  }
  void add_to(T* x, const T& factor) const {
    each([&](int i) { x[column[i]] += factor * value[i]; });
  }

 private:
  /// Calls f with the index of each entry; without a loop for the usual row, of two moving bodies.
  template <class F>
  [[gnu::always_inline]] void each(F f) const {
    if (std::is_same_v<T, double> && size == max_size) {
#pragma GCC unroll 6
      for (int i = 0; i < max_size; ++i) f(i);
    } else {
      for (int i = 0; i < size; ++i) f(i);
    }
  }
};
using SparseRow = SparseRowOf<double>;

// Independent rows of a sparse matrix.

/// Indices (ascending) of a largest set of independent rows of G M^(−1/2), with each row scaled to
/// unit length, by rank-revealing sparse QR. A row is dependent if its distance from the span of
/// the others is less than `tolerance`.
std::vector<int> independent_rows(const CsrPattern& G, std::span<const double> values,
                                  std::span<const double> mass, double tolerance = 1e-9);

}  // namespace freeplay
