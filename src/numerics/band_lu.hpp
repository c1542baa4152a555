// LU factors of a band matrix by Gaussian elimination with partial pivoting (Golub and Van Loan,
// Matrix Computations, 4th ed., section 4.3.5): n w² operations for half-bandwidth w. The storage
// grows and is never released.
//
// Row i holds columns i − w … i + 2w, because row interchanges widen the upper band to 2w.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

namespace freeplay {

class BandLu {
 public:
  /// Starts an empty matrix of n rows and half-bandwidth w.
  void begin(int n, int w) {
    n_ = n;
    w_ = w;
    width_ = 3 * w + 1;
    entries_.assign(static_cast<std::size_t>(n) * static_cast<std::size_t>(width_), 0.0);
    pivot_.resize(static_cast<std::size_t>(n));
  }
  double& at(int i, int j) {
    return entries_[static_cast<std::size_t>(i) * static_cast<std::size_t>(width_) +
                    static_cast<std::size_t>(j - i + w_)];
  }
  /// Factorises in place. Returns false if a pivot is at most `least`.
  [[nodiscard]] bool factor(double least) {
    for (int k = 0; k < n_; ++k) {
      const int last = std::min(n_ - 1, k + w_), right = std::min(n_ - 1, k + 2 * w_);
      int p = k;
      for (int i = k + 1; i <= last; ++i)
        if (std::abs(at(i, k)) > std::abs(at(p, k))) p = i;
      pivot_[static_cast<std::size_t>(k)] = p;
      if (!(std::abs(at(p, k)) > least)) return false;
      if (p != k)
        for (int j = k; j <= right; ++j) std::swap(at(k, j), at(p, j));
      for (int i = k + 1; i <= last; ++i) {
        const double x = at(i, k) /= at(k, k);
        if (x == 0) continue;
        for (int j = k + 1; j <= right; ++j) at(i, j) -= x * at(k, j);
      }
    }
    return true;
  }
  void solve(double* x) {
    for (int k = 0; k < n_; ++k) {
      if (const int p = pivot_[static_cast<std::size_t>(k)]; p != k) std::swap(x[k], x[p]);
      for (int i = k + 1; i <= std::min(n_ - 1, k + w_); ++i) x[i] -= at(i, k) * x[k];
    }
    for (int k = n_ - 1; k >= 0; --k) {
      for (int j = k + 1; j <= std::min(n_ - 1, k + 2 * w_); ++j) x[k] -= at(k, j) * x[j];
      x[k] /= at(k, k);
    }
  }

 private:
  int n_ = 0, w_ = 0, width_ = 1;
  std::vector<double> entries_;
  std::vector<int> pivot_;
};

}  // namespace freeplay
