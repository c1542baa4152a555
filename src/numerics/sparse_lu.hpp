// SparseLu: LU factors of a sparse square matrix with a symmetric pattern, by KLU with
// minimum-degree order (Davis and Palamadai Natarajan, ACM Trans. Math. Softw. 37 (2010) 36; Amestoy,
// Davis and Duff, SIAM J. Matrix Anal. Appl. 17 (1996) 886).
//
// Usage:
//
//     lu.analyse(begin, column);                 // compressed rows
//     lu.values()[e] = ...;                      // in the order of `column`
//     if (lu.factor(1e-11)) lu.solve(x);
//
// The analysis of the last pattern is kept. Factors depend on the values only, not on former ones: pivots
// are those on the diagonal, or where these differ too much, the ones that partial pivoting chooses.
#pragma once

#include <memory>
#include <vector>

namespace freeplay {

class SparseLu {
 public:
  SparseLu();
  ~SparseLu();
  SparseLu(SparseLu&&) noexcept;
  SparseLu& operator=(SparseLu&&) noexcept;

  /// Takes the pattern by exchange of its vectors, and orders it, unless it is the present one.
  void analyse(std::vector<int>& begin, std::vector<int>& column);
  std::vector<double>& values() { return values_; }
  /// Returns false if the ratio of the least to the greatest pivot is at most `least`.
  [[nodiscard]] bool factor(double least);
  void solve(double* x);

 private:
  struct Factors;
  std::vector<int> begin_, column_;
  std::vector<double> values_;
  std::unique_ptr<Factors> factors_;
};

}  // namespace freeplay
