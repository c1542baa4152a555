#include "numerics/sparse_lu.hpp"

#include <klu.h>

namespace freeplay {

// The rows are columns for KLU, which factorises the transpose.
struct SparseLu::Factors {
  klu_common common;
  klu_symbolic* symbolic = nullptr;
  klu_numeric* numeric = nullptr;

  Factors() {
    klu_defaults(&common);
    common.btf = 0;  // no permutation to block triangular form: contacts couple all rows
  }
  ~Factors() { clear(); }
  void clear() {
    klu_free_numeric(&numeric, &common);
    klu_free_symbolic(&symbolic, &common);
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
  auto& f = *factors_;
  klu_free_numeric(&f.numeric, &f.common);
  if (f.symbolic)
    f.numeric = klu_factor(begin_.data(), column_.data(), values_.data(), f.symbolic, &f.common);
  return f.numeric && f.common.status == KLU_OK && klu_rcond(f.symbolic, f.numeric, &f.common) &&
         f.common.rcond > least;
}

void SparseLu::solve(double* x) {
  auto& f = *factors_;
  klu_tsolve(f.symbolic, f.numeric, static_cast<int>(begin_.size()) - 1, 1, x, &f.common);
}

}  // namespace freeplay
