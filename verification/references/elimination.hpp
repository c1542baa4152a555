// Gaussian elimination: solves a x = b for a square matrix of any container of rows. With pivots,
// rows are exchanged for the greatest entry of each column; a symmetric positive definite matrix
// needs none.
#pragma once

#include <cmath>
#include <cstddef>
#include <utility>

namespace freeplay::reference {

enum class Pivots { rows, none };

/// Replaces b by x, and a by its triangular factor; false if a is singular.
template <class Matrix, class Vector>
bool eliminate(Matrix& a, Vector& b, Pivots pivots = Pivots::rows) {
  const std::size_t n = b.size();
  for (std::size_t c = 0; c < n; ++c) {
    std::size_t p = c;
    for (std::size_t r = c + 1; r < n && pivots == Pivots::rows; ++r)
      if (std::abs(a[r][c]) > std::abs(a[p][c])) p = r;
    if (a[p][c] == 0) return false;
    std::swap(a[p], a[c]), std::swap(b[p], b[c]);
    for (std::size_t r = c + 1; r < n; ++r) {
      const auto factor = a[r][c] / a[c][c];
      for (std::size_t k = c; k < n; ++k) a[r][k] -= factor * a[c][k];
      b[r] -= factor * b[c];
    }
  }
  for (std::size_t c = n; c-- > 0;) {
    for (std::size_t k = c + 1; k < n; ++k) b[c] -= a[c][k] * b[k];
    b[c] /= a[c][c];
  }
  return true;
}

}  // namespace freeplay::reference
