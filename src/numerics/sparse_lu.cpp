#include "numerics/sparse_lu.hpp"

#include <klu.h>

#include <algorithm>

namespace freeplay {

// The rows are columns for KLU, which factorises the transpose.
struct SparseLu::Factors {
  klu_common common;
  klu_symbolic* symbolic = nullptr;
  klu_numeric* numeric = nullptr;
  bool on_diagonal = false;  // whether all pivots of `numeric` are

  Factors() {
    klu_defaults(&common);
    common.btf = 0;  // no permutation to block triangular form: contacts couple all rows
  }
  ~Factors() { clear(); }
  void clear() {
    klu_free_numeric(&numeric, &common);
    klu_free_symbolic(&symbolic, &common);
    on_diagonal = false;
  }
  /// `threshold`: least ratio of a pivot on the diagonal to the greatest entry.
  void make(std::vector<int>& begin, std::vector<int>& column, std::vector<double>& values,
            double threshold) {
    common.tol = threshold;
    klu_free_numeric(&numeric, &common);
    numeric = klu_factor(begin.data(), column.data(), values.data(), symbolic, &common);
    on_diagonal = numeric && common.noffdiag == 0;
  }
  bool regular(double least) {
    return numeric && common.status == KLU_OK && klu_rcond(symbolic, numeric, &common) &&
           common.rcond > least;
  }
};

SparseLu::SparseLu() = default;
SparseLu::~SparseLu() = default;
SparseLu::SparseLu(SparseLu&&) noexcept = default;
SparseLu& SparseLu::operator=(SparseLu&&) noexcept = default;

void SparseLu::analyse(std::vector<int>& begin, std::vector<int>& column) {
  if (factors_ && begin == begin_ && column == column_) return;
  begin_.swap(begin);
  column_.swap(column);
  values_.resize(column_.size());
  if (!factors_) factors_ = std::make_unique<Factors>();
  factors_->clear();
  factors_->symbolic =
      klu_analyze(static_cast<int>(begin_.size()) - 1, begin_.data(), column_.data(), &factors_->common);
}

bool SparseLu::factor(double least) {
  constexpr double safe = 1e-9;  // ratio of pivots from which those on the diagonal are used
  auto& f = *factors_;
  if (!f.symbolic) return false;
  // Pivots on the diagonal have one order for a pattern: no allocation, and no trace of former values.
  if (f.on_diagonal)
    klu_refactor(begin_.data(), column_.data(), values_.data(), f.symbolic, f.numeric, &f.common);
  else
    f.make(begin_, column_, values_, 0);
  if (f.on_diagonal && f.regular(std::max(least, safe))) return true;
  f.make(begin_, column_, values_, 1e-3);
  f.on_diagonal = false;
  return f.regular(least);
}

void SparseLu::solve(double* x) {
  auto& f = *factors_;
  klu_tsolve(f.symbolic, f.numeric, static_cast<int>(begin_.size()) - 1, 1, x, &f.common);
}

}  // namespace freeplay
