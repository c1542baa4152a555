// ActiveRows: the rows that take part in a problem of the event-driven scheme. With the response
// r = A w of the mechanism to a unit force along a row w (A the inverse of the saddle point), the
// rows W and the responses X,
//
//     K x = b,   K = W X.
//
// The row of a sliding contact responds to the normal force and its friction together, so K need
// not be symmetric. If there are several solutions (sticking contacts of one body share a row),
// solve() gives the one of least norm.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "numerics/dense.hpp"
#include "numerics/saddle_point.hpp"

namespace freeplay {

class ActiveRows {
 public:
  /// For a mechanism of n coordinates and m constraint rows; at most `most` rows are active at one
  /// time.
  ActiveRows(int n, int m, int most);

  void clear() { used_ = 0; }
  int used() const { return used_; }
  int most() const { return static_cast<int>(rows_.size()); }
  /// Adds a row and the response to `row` + `factor` · `beside`; returns its index.
  int add(SaddlePoint& saddle, const SparseRow& row, const SparseRow* beside = nullptr, double factor = 0);
  /// The same at place `r` after the rows in use, without counting it.
  void put(int r, SaddlePoint& saddle, const SparseRow& row, const SparseRow* beside = nullptr,
           double factor = 0);

  const SparseRow& row(int r) const { return rows_[static_cast<std::size_t>(r)]; }
  /// n numbers
  const double* response(int r) const { return response_.data() + static_cast<long>(r) * n_; }
  const double* reaction(int r) const {
    return reaction_.data() + static_cast<long>(r) * m_;
  }  ///< m multipliers

  void fill();            ///< K of all rows
  void fill_symmetric();  ///< K of rows whose response is to themselves alone
  void solve();           ///< K x = b of the rows in use
  /// The least x/√weight: if K is singular, forces are shared in proportion to the weights (one per
  /// row).
  void share(const Eigen::VectorXd& weight);
  /// The least of these with C x + c ≥ 0. Returns false and keeps x if there are none.
  bool share_within(const Eigen::VectorXd& weight, const Eigen::MatrixXd& C, const Eigen::VectorXd& c);
  bool dependent() const { return dependent_; }  ///< K was singular in the last solve()
  /// sign of the determinant of K in the last solve()
  int turn() const { return turn_; }
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
