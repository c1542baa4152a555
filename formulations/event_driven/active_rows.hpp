// Rows that take part in a problem of the event-driven scheme: with r = A w the response of the mechanism to a unit of a row's
// force (A the inverse of the saddle point), W the rows and X the responses,
//
//     K x = b,   K = W X.
//
// Rows of what slides respond to their normal and its friction together, so K need not be symmetric. Of several solutions
// (sticking feet of one body share a row) the shortest is taken.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "numerics/dense.hpp"
#include "numerics/saddle_point.hpp"

namespace freeplay {

class ActiveRows {
 public:
  /// For a mechanism of n coordinates and m constraint rows; at most `most` rows act at one time.
  ActiveRows(int n, int m, int most);

  void clear() { used_ = 0; }
  int used() const { return used_; }
  int most() const { return static_cast<int>(rows_.size()); }
  /// Adds a row and its response to `row` + `factor` · `beside`; returns its index.
  int add(SaddlePoint& saddle, const SparseRow& row, const SparseRow* beside = nullptr, double factor = 0);
  /// The same at place `r` behind those in use, without counting it.
  void put(int r, SaddlePoint& saddle, const SparseRow& row, const SparseRow* beside = nullptr,
           double factor = 0);

  const SparseRow& row(int r) const { return rows_[static_cast<std::size_t>(r)]; }
  const double* response(int r) const { return response_.data() + static_cast<long>(r) * n_; }  ///< n numbers
  const double* reaction(int r) const {
    return reaction_.data() + static_cast<long>(r) * m_;
  }  ///< m multipliers

  void fill();            ///< K of all rows
  void fill_symmetric();  ///< the same of rows that respond to themselves alone
  void solve();           ///< K x = b of the rows in use
  /// The shortest x/√weight: where K is dependent forces are shared in proportion to the weights (one per row).
  void share(const Eigen::VectorXd& weight);
  bool dependent() const { return dependent_; }  ///< at the last solve()
  int turn() const { return turn_; }             ///< sign of the determinant of K then
  /// Adds the response to x to accelerations (or rates) `a` and multipliers `lambda`.
  void apply(double* a, double* lambda) const;

  Eigen::MatrixXd K;
  Eigen::VectorXd b, x;

 private:
  void make_room(int rows);

  int n_, m_, used_ = 0, room_ = 0;
  std::vector<SparseRow> rows_;
  std::vector<double> response_, reaction_;
  DenseLu lu_;
  bool dependent_ = false;
  int turn_ = 1;
};

}  // namespace freeplay
